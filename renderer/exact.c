// exact.c - Xu 2011, eq 11 by quadrature, with nothing approximated.
//
// Two changes of variable take the singularities away.  The sum over the roots
// of phi(p, h) = phi in eq 9 is turned back into an integral over h, so that
// no root is sought and no caustic divides by zero:
//   Int g(Phi - phi) N(phi) dphi = 1/2 Int A(h) g(Phi - phi(h)) dh,
// and h = sin gamma removes the square roots at h = +-1.  The inner integrals
// halve their panels until a panel sees only a part of a lobe, and leave out
// panels that the lobe does not reach; the outer one is adaptive.
// How the scene's schemes approximate all this is not known here.
#include "renderer/exact.h"
#include "renderer/quadrature.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>

static const double pi = 3.14159265358979323846;
// Exponents below this add nothing to a double.
#define REACH 10.0 // widths from a centre at which a lobe is < e^-40
#define DARK 720.0

struct path { // of one mode at one theta_d
    const struct exact_case *c;
    int mode;
    double cos_d, sin2_d; // theta_d
    double eta1;          // eta' of the geometry (Xu 2011, Table 1)
    double eta1_real;     // eta' of absorption
    double sigma;         // sigma_a' (Xu 2011, Table 1)
    double kappa, centre; // light: 2 / lambda'^2, Phi = phi_o - phi_j
    double kappa_c;       // 2 / w_c^2
    double norm_c;        // 1 / Int of the smoothing Gaussian
    double width;         // of light and smoothing together
};

// --- special functions ------------------------------------------------------
double exact_i0e(double x)
{
    double term = 1, sum = 1;
    if (x < 20) { // power series, all terms positive
        for (int k = 1; k < 80 && term > 1e-17 * sum; k++) {
            term *= (x / (2 * k)) * (x / (2 * k));
            sum += term;
        }
        return sum * exp(-x);
    }
    for (int k = 1; k < 30; k++) { // asymptotic, stopped before it grows
        double next = term * (2 * k - 1) * (2 * k - 1) / (8 * x * k);
        if (next > term || next < 1e-17 * sum)
            break;
        sum += term = next;
    }
    return sum / sqrt(2 * pi * x);
}

double exact_fresnel(double eta, double cos_i)
{
    double q = sqrt(eta * eta - 1 + cos_i * cos_i);
    double s = (cos_i - q) / (cos_i + q);
    double e2 = eta * eta * cos_i, p = (e2 - q) / (e2 + q);
    return (s * s + p * p) / 2;
}

// Integral over a period of exp(k1 (cos x - 1) + k2 (cos(d - x) - 1)).
static double gauss_product(double d, double k1, double k2)
{
    double s = sin(d / 2), c = cos(d / 2);
    double k = sqrt((k1 - k2) * (k1 - k2) + 4 * k1 * k2 * c * c);
    double less = 4 * k1 * k2 * s * s / (k + k1 + k2);
    return less > DARK ? 0 : 2 * pi * exact_i0e(k) * exp(-less);
}

// --- quadrature -------------------------------------------------------------

// Gauss-Kronrod 7-15; nodes 1, 3, 5, 7 are Gauss's.
static const double gk_x[8] = {0.991455371120812640, 0.949107912342758525,
                               0.864864423359769073, 0.741531185599394440,
                               0.586087235467691130, 0.405845151377397167,
                               0.207784955007898468, 0};
static const double gk_w[8] = {0.022935322010529225, 0.063092092629978553,
                               0.104790010322250184, 0.140653259715525919,
                               0.169004726639267903, 0.190350578064785410,
                               0.204432940075298892, 0.209482141084727828};
static const double g_w[4] = {0.129484966168869693, 0.279705391489276668,
                              0.381830050505118945, 0.417959183673469388};

static double kronrod(exact_integrand *f, void *self, const double x[2],
                      double *err)
{
    double mid = (x[0] + x[1]) / 2, half = (x[1] - x[0]) / 2;
    double k = 0, g = 0;
    for (int i = 0; i < 8; i++) {
        double v = f(self, mid + half * gk_x[i]);
        if (i < 7)
            v += f(self, mid - half * gk_x[i]);
        k += gk_w[i] * v;
        if (i % 2)
            g += g_w[i / 2] * v;
    }
    *err = fabs(k - g) * half;
    return k * half;
}

static double adapt(exact_integrand *f, void *self, const double x[2],
                    double tol, int depth)
{
    double err, sum = kronrod(f, self, x, &err);
    if (err <= fmax(tol, 1e-7 * fabs(sum)) || depth == 0)
        return sum;
    double mid = (x[0] + x[1]) / 2;
    const double left[2] = {x[0], mid}, right[2] = {mid, x[1]};
    return adapt(f, self, left, tol, depth - 1) +
           adapt(f, self, right, tol, depth - 1);
}

double exact_integral(exact_integrand *f, void *self, const double *edge,
                      int panels, double tolerance)
{
    double part[EXACT_PANELS_MAX], part_err[EXACT_PANELS_MAX], sum = 0, all = 0;
    assert(panels <= EXACT_PANELS_MAX);
    for (int i = 0; i < panels; i++) {
        part[i] = part_err[i] = 0;
        if (edge[i + 1] > edge[i])
            part[i] = kronrod(f, self, edge + i, part_err + i);
        sum += part[i];
    }
    double tol = tolerance * fabs(sum);
    for (int i = 0; i < panels; i++)
        all += part_err[i] <= tol ? part[i] : adapt(f, self, edge + i, tol, 12);
    return all;
}

// --- one path through the fibre ---------------------------------------------
static double turn(const struct path *p, double gamma) // phi(h), eq 8
{
    double inside = p->mode ? asin(sin(gamma) / p->eta1) : 0;
    return 2 * p->mode * inside - 2 * gamma + pi * p->mode;
}

static double absorbed(const struct path *p, double gamma)
{
    double x = sin(gamma) / p->eta1_real;
    return p->mode ? 2 * p->mode * p->sigma * sqrt(1 - x * x) : 0;
}

static double attenuation(const struct path *p, double gamma) // eq 10
{
    double f = exact_fresnel(p->c->eta, p->cos_d * cos(gamma));
    if (p->mode == EXACT_R)
        return f;
    double t = absorbed(p, gamma);
    return t > DARK
               ? 0
               : (1 - f) * (1 - f) * (p->mode == EXACT_TRT ? f : 1) * exp(-t);
}

static double light_lobe(const struct path *p, double d)
{
    if (p->mode == EXACT_TRT)
        return gauss_product(d, p->kappa, p->kappa_c) * p->norm_c;
    double s = sin(d / 2);
    return exp(-2 * p->kappa * s * s);
}

// The azimuth of the ellipse turns index and path with it (Marschner 2003,
// 5.2.3), so the light's azimuth x has to be integrated for every h.
struct turned {
    struct path path;
    double gamma, weight;
    double lipschitz; // bound of |d phi(h; x) / dx|
};

static double eta_star(const struct exact_case *c, double x)
{
    double aa = c->a * c->a, e1 = 2 * (c->eta - 1) * aa - c->eta + 2;
    double e2 = 2 * (c->eta - 1) / aa - c->eta + 2;
    return (e1 + e2 + cos(x + c->phi_j + c->phi_o) * (e1 - e2)) / 2;
}

static double eta_prime(double eta, const struct path *p)
{
    return sqrt(eta * eta - p->sin2_d) / p->cos_d;
}

static double over_light(struct turned *t, double a, double b, int depth)
{
    struct path *p = &t->path;
    double mid = (a + b) / 2, half = (b - a) / 2, lambda = sqrt(2 / p->kappa);
    double w = p->c->w_c, slope = 1 + t->lipschitz;
    p->eta1 = eta_prime(eta_star(p->c, mid), p);
    double u = remainder(p->centre - mid - turn(p, t->gamma), 2 * pi);
    if (fabs(u) - slope * half > REACH * w)
        return 0;
    if (depth > 0 && (slope * half > w || half > 0.75 * lambda || half > 0.3))
        return over_light(t, a, mid, depth - 1) +
               over_light(t, mid, b, depth - 1);
    double sum = 0;
    for (int i = 0; i < 8; i++) {
        double x = mid + (i < 4 ? half : -half) * quadrature_x[i % 4];
        p->eta1 = eta_prime(eta_star(p->c, x), p);
        u = p->centre - x - turn(p, t->gamma);
        double s = sin(x / 2), v = sin(u / 2);
        sum += quadrature_w[i % 4] *
               exp(-2 * p->kappa * s * s - 2 * p->kappa_c * v * v);
    }
    return sum * half;
}

static double turned_lobe(const struct path *path, double gamma)
{
    struct turned t = {.path = *path, .gamma = gamma};
    double aa = path->c->a * path->c->a, swing = path->c->eta - 1;
    double mid = 1 + swing * (aa + 1 / aa - 1);
    double amplitude = swing * fabs(aa - 1 / aa);
    double e = eta_prime(mid - amplitude, path), h = sin(gamma) / e;
    double d_eta =
        amplitude * (mid + amplitude) / (path->cos_d * path->cos_d * e);
    t.lipschitz = 4 * fabs(h) / (e * sqrt(1 - h * h)) * d_eta;
    double reach = fmin(pi, REACH * sqrt(2 / path->kappa));
    return over_light(&t, -reach, reach, 30) * path->norm_c;
}

// --- integral over the fibre's width ----------------------------------------
// Panels of gamma within which phi(h) is monotone.  sign: which half of h.
static double over_panel(const struct path *p, double sign, const double x[2],
                         int depth)
{
    double a = turn(p, x[0]), b = turn(p, x[1]), span = fabs(b - a);
    double la = absorbed(p, x[0]), lb = absorbed(p, x[1]);
    bool round = p->mode != EXACT_TRT || p->c->a == 1;
    if (fmin(la, lb) > DARK)
        return 0;
    double away = remainder(p->centre - sign * (a + b) / 2, 2 * pi);
    if (round && fabs(away) - span / 2 > REACH * p->width)
        return 0;
    double edge = sqrt(fmax(0, p->eta1 * p->eta1 - 1)) + pi / 2 - x[1];
    double length = x[1] - x[0];
    if (depth > 0 && (span > 2 * p->width || length > 0.41 ||
                      (p->mode && length > edge) || fabs(la - lb) > 4)) {
        double mid = (x[0] + x[1]) / 2;
        const double left[2] = {x[0], mid}, right[2] = {mid, x[1]};
        return over_panel(p, sign, left, depth - 1) +
               over_panel(p, sign, right, depth - 1);
    }
    double sum = 0;
    for (int i = 0; i < 8; i++) {
        double g = (x[0] + x[1]) / 2 +
                   (i < 4 ? length : -length) / 2 * quadrature_x[i % 4];
        double weight = quadrature_w[i % 4] * cos(g) * attenuation(p, g);
        if (weight <= 0)
            continue;
        sum += weight * (round ? light_lobe(p, p->centre - sign * turn(p, g))
                               : turned_lobe(p, sign * g));
    }
    return sum * length / 4; // dgamma, and the half of eq 9
}

static double over_width(const struct path *p)
{
    double fold = pi / 2, sum = 0; // where phi(h) turns back
    if (p->mode == EXACT_TRT && p->eta1 < 2 && p->eta1 > 1)
        fold = asin(sqrt((4 - p->eta1 * p->eta1) / 3));
    const double first[2] = {0, fold}, second[2] = {fold, pi / 2};
    for (double sign = -1; sign <= 1; sign += 2) {
        sum += over_panel(p, sign, first, 30);
        if (fold < pi / 2)
            sum += over_panel(p, sign, second, 30);
    }
    return sum;
}

// 1/2 Int A dh = Int N dphi.
static double over_all(const struct path *p)
{
    double sum = 0;
    for (int panel = 0; panel < 8; panel++)
        for (int i = 0; i < 8; i++) {
            double x = i < 4 ? quadrature_x[i] : -quadrature_x[i - 4];
            double g = pi / 16 * (panel + 0.5 + x / 2);
            sum += quadrature_w[i % 4] * cos(g) * attenuation(p, g);
        }
    return sum * pi / 32;
}

// --- integral over the light's inclination ----------------------------------
struct outer {
    const struct exact_case *c;
    int mode;
    bool mean; // over phi_o, instead of at phi_o
    double top;
};

// log of G_j's theta part times M_t, without M_t's constant.
static double log_weight(const struct outer *o, double theta)
{
    const struct exact_case *c = o->c;
    double s = sin((theta - c->theta_j) / 2) / c->lambda_j;
    double t = (theta + c->theta_o - 2 * c->alpha[o->mode]) /
               (2 * sqrt(2) * c->beta[o->mode]);
    return -4 * s * s - t * t;
}

static double at_theta(void *self, double theta)
{
    const struct outer *o = self;
    const struct exact_case *c = o->c;
    double weight = exp(log_weight(o, theta) - o->top);
    double ci = cos(theta), theta_d = (c->theta_o - theta) / 2;
    double sd = sin(theta_d), cd = cos(theta_d), w = c->w_c;
    if (ci < 1e-12 || cd < 1e-12)
        return 0;
    double k = 2 * ci * fmax(0, cos(c->theta_j)) / (c->lambda_j * c->lambda_j);
    struct path p = {.c = c,
                     .mode = o->mode,
                     .cos_d = cd,
                     .sin2_d = sd * sd,
                     .kappa = fmax(k, 1e-12),
                     .centre = c->phi_o - c->phi_j,
                     .kappa_c = 2 / (w * w)};
    p.eta1 = p.eta1_real = eta_prime(c->eta, &p);
    p.sigma = c->sigma_a / sqrt(1 - p.sin2_d / (c->eta * c->eta));
    p.norm_c = 1 / (2 * pi * exact_i0e(p.kappa_c));
    p.width = sqrt(2 / p.kappa);
    if (o->mode == EXACT_TRT)
        p.width = c->a == 1 ? hypot(p.width, w) : w;
    double n = o->mean ? exact_i0e(p.kappa) * over_all(&p) : over_width(&p);
    return weight * ci * ci / (cd * cd) * n;
}

// Where the weight is largest: a scan, then golden section about the best.
static double peak(const struct outer *o)
{
    const struct exact_case *c = o->c;
    double lj2 = c->lambda_j * c->lambda_j;
    double l12 = 8 * c->beta[o->mode] * c->beta[o->mode];
    double mu = 2 * c->alpha[o->mode] - c->theta_o, best = 0, top = -INFINITY;
    double step = pi / 128;
    for (int i = 0; i <= 131; i++) {
        double x = -pi / 2 + step * i;
        if (i == 129)
            x = mu;
        if (i == 130)
            x = c->theta_j;
        if (i == 131)
            x = (mu * lj2 + c->theta_j * l12) / (l12 + lj2);
        x = fmin(fmax(x, -pi / 2), pi / 2);
        double v = log_weight(o, x);
        if (v > top) {
            top = v;
            best = x;
        }
    }
    double a = fmax(best - step, -pi / 2), b = fmin(best + step, pi / 2);
    for (int i = 0; i < 60; i++) {
        double third = (b - a) * 0.381966011250105;
        if (log_weight(o, a + third) < log_weight(o, b - third))
            a += third;
        else
            b -= third;
    }
    return (a + b) / 2;
}

// The point beyond which the weight is below e^-45 of its top, or +-pi/2.
static double reach(const struct outer *o, double from, double sign)
{
    double step = 1e-3 * fmin(1, o->c->lambda_j), x = from;
    while (fabs(x) <= pi / 2 && log_weight(o, x) > o->top - 45) {
        x += sign * step;
        step *= 1.3;
    }
    return fmin(fmax(x, -pi / 2), pi / 2);
}

static double mode(const struct exact_case *c, int t, bool mean)
{
    struct outer o = {.c = c, .mode = t, .mean = mean};
    double top = peak(&o);
    o.top = log_weight(&o, top);
    double lo = reach(&o, top, -1), hi = reach(&o, top, 1);
    double edge[7] = {lo,  (2 * lo + top) / 3, (lo + 2 * top) / 3,
                      top, (hi + 2 * top) / 3, (2 * hi + top) / 3,
                      hi};
    // The azimuth of an ellipse is a third integral: a tenth of the digits.
    double tol = t == EXACT_TRT && c->a != 1 ? 1e-5 : 1e-8;
    double sum = exact_integral(at_theta, &o, edge, 6, tol);
    return exp(o.top) * sum / (sqrt(pi) * 2 * sqrt(2) * c->beta[t]);
}

void exact_modes(const struct exact_case *c, double out[EXACT_MODES])
{
    for (int t = 0; t < EXACT_MODES; t++)
        out[t] = mode(c, t, false);
}

void exact_means(const struct exact_case *c, double out[EXACT_MODES])
{
    for (int t = 0; t < EXACT_MODES; t++)
        out[t] = mode(c, t, true);
}
