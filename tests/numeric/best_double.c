// best_double.c - see the header.  Nothing here is shared with the renderer but
// the struct of inputs, so that a slip in one is seen by the other.
#include "tests/numeric/best_double.h"

#include <math.h>
#include <stddef.h>

static const double pi = 3.14159265358979323846;

enum { MEAN = 4, LOBE = 5, PANELS = 3, FINE = 32 };

struct nodes { // of Gauss-Legendre on [a, b]
    double x[FINE], w[FINE];
};

static struct nodes between(int count, double a, double b)
{
    struct nodes n;
    for (int i = 0; i < count; i++) {
        double x = cos(pi * (i + 0.75) / (count + 0.5)), slope = 1;
        for (int turn = 0; turn < 9; turn++) { // Newton on P_n
            double p0 = 1, p1 = x;
            for (int k = 2; k <= count; k++) {
                double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = count * (x * p1 - p0) / (x * x - 1);
            x -= p1 / slope;
        }
        n.x[i] = (a + b) / 2 + (b - a) / 2 * x;
        n.w[i] = (b - a) / ((1 - x * x) * slope * slope);
    }
    return n;
}

// First moment of a circular Gaussian and e^-k I_0, from their definitions.
static double circular(double k, double *moment)
{
    double reach = k > 40 ? acos(1 - 40 / k) : pi, sum = 0, first = 0;
    int n = 300;
    for (int i = 0; i <= n; i++) {
        double x = reach * i / n, s = sin(x / 2);
        double g = exp(-2 * k * s * s) * (i == 0 || i == n ? 0.5 : 1);
        sum += g;
        first += g * 2 * s * s;
    }
    if (moment)
        *moment = 1 - first / sum;
    return sum * reach / n / pi;
}

static double kappa_of(double moment)
{
    double lo = 1e-6, hi = 1e9; // bisection in the logarithm
    for (int i = 0; i < 100; i++) {
        double mid = sqrt(lo * hi), at;
        circular(mid, &at);
        *(at < moment ? &lo : &hi) = mid;
    }
    return sqrt(lo * hi);
}

struct place {
    const struct exact_case *c;
    double cos_d, eta1, sigma; // eta', sigma_a'
    double kappa, lambda, phi; // the light's
};

static double light(const struct place *p, double phi)
{
    double a = sin((phi - p->phi) / 2), b = sin((phi + p->phi) / 2);
    return exp(-2 * p->kappa * a * a) + exp(-2 * p->kappa * b * b);
}

// The mean of N_R under the light, times the light's mass.
static double n_r(const struct place *p)
{
    double reach = 1.85 * p->lambda, sum = 0, mass = 0;
    struct nodes n =
        between(MEAN, fmax(0, p->phi - reach), fmin(pi, p->phi + reach));
    for (int i = 0; i < MEAN; i++) {
        double u = fabs(cos(n.x[i] / 2)), g = n.w[i] * light(p, n.x[i]);
        sum += g * u * exact_fresnel(p->c->eta, p->cos_d * u) / 4;
        mass += g;
    }
    return 2 * pi * circular(p->kappa, NULL) * sum / mass;
}

// phi = pi - delta; gamma_i by solving eq 8, which the shader has in closed
// form.
static double gamma_of(const struct place *p, double delta)
{
    double lo = 0, hi = pi / 2;
    for (int i = 0; i < 60; i++) {
        double g = (lo + hi) / 2;
        *(2 * g - 2 * asin(sin(g) / p->eta1) < delta ? &lo : &hi) = g;
    }
    return (lo + hi) / 2;
}

static double n_tt(struct place p)
{
    double last = pi - 2 * asin(1 / p.eta1), near = pi - p.phi;
    double hi = fmin(last, near + 2.1 * p.lambda);
    double lo = fmax(0, fmin(near - 2.1 * p.lambda, hi - 3.2 * p.lambda));
    double sum[3] = {0};
    struct nodes n = between(LOBE, lo, hi);
    p.phi = near;
    for (int i = 0; i < LOBE; i++) {
        double g = gamma_of(&p, n.x[i]), h = sin(g) / p.eta1;
        double ct = sqrt(1 - h * h),
               f = exact_fresnel(p.c->eta, p.cos_d * cos(g));
        double turn = 2 - 2 * cos(g) / (p.eta1 * ct); // |dphi/dgamma|
        double v = n.w[i] * light(&p, n.x[i]) * (1 - f) * (1 - f) * cos(g) /
                   (2 * turn);
        sum[0] += v;
        sum[1] += v * ct;
        sum[2] += v * ct * ct;
    }
    if (sum[0] <= 0)
        return 0;
    double ct = sum[1] / sum[0], dark = 2 * p.sigma;
    return sum[0] * exp(-dark * ct) *
           (1 + dark * dark / 2 * (sum[2] / sum[0] - ct * ct));
}

static double product(double d, double k1, double k2)
{
    double s = sin(d / 2), c = cos(d / 2);
    double k = sqrt((k1 - k2) * (k1 - k2) + 4 * k1 * k2 * c * c);
    return 2 * pi * circular(k, NULL) *
           exp(-4 * k1 * k2 * s * s / (k + k1 + k2));
}

static double mean_eta(const struct place *p)
{
    const struct exact_case *c = p->c;
    double moment, aa = c->a * c->a;
    circular(p->kappa, &moment);
    double e1 = 2 * (c->eta - 1) * aa - c->eta + 2;
    double e2 = 2 * (c->eta - 1) / aa - c->eta + 2;
    return (e1 + e2 + moment * cos(c->phi_o + c->phi_j) * (e1 - e2)) / 2;
}

static double n_trt(const struct place *p)
{
    static const double cut[PANELS + 1] = {0, 0.6, 0.94, 1};
    const struct exact_case *c = p->c;
    double star = mean_eta(p), sin2 = 1 - p->cos_d * p->cos_d, sum = 0, moment;
    double turned = sqrt(star * star - sin2) / p->cos_d;
    circular(2 / (c->w_c * c->w_c), &moment);
    for (int q = 0; q < PANELS; q++) {
        struct nodes n = between(FINE, asin(cut[q]), asin(cut[q + 1]));
        double w = 0, x = 0, y = 0;
        for (int i = 0; i < FINE; i++) {
            double h = sin(n.x[i]), t = h / p->eta1, u = cos(n.x[i]);
            double f = exact_fresnel(c->eta, p->cos_d * u);
            double phi = 4 * asin(h / turned) - 2 * n.x[i];
            double v = n.w[i] * u * (1 - f) * (1 - f) * f *
                       exp(-4 * p->sigma * sqrt(1 - t * t));
            w += v;
            x += v * cos(phi);
            y += v * sin(phi);
        }
        if (w <= 0)
            continue;
        double k = kappa_of(hypot(x, y) / w * moment), phi = atan2(y, x);
        sum += w / (4 * pi * circular(k, NULL)) *
               (product(p->phi - phi, p->kappa, k) +
                product(p->phi + phi, p->kappa, k));
    }
    return sum;
}

static double azimuth(const struct exact_case *c, int t, double theta_i)
{
    double cd = cos((c->theta_o - theta_i) / 2), ci = cos(theta_i);
    double root = sqrt(c->eta * c->eta - 1 + cd * cd);
    struct place p = {.c = c,
                      .cos_d = cd,
                      .eta1 = root / cd,
                      .sigma = c->sigma_a * c->eta / root,
                      .phi = fabs(remainder(c->phi_o - c->phi_j, 2 * pi))};
    p.kappa = 2 * ci * cos(c->theta_j) / (c->lambda_j * c->lambda_j);
    p.lambda = sqrt(2 / p.kappa);
    double n = t == EXACT_R ? n_r(&p) : t == EXACT_TT ? n_tt(p) : n_trt(&p);
    return ci * ci / (cd * cd) * n;
}

// The three-node Gauss rule of exp(-t^2) on [-far, near] by Stieltjes'
// procedure: the nodes' distances from the near end, and weights times e^(t^2).
struct rule {
    double off[3], weight[3];
};

struct recurrence { // of the polynomials that are orthogonal there
    double a[3], b[3], norm[3];
};

static struct recurrence orthogonal(double lo, double hi, double near2)
{
    struct recurrence r;
    struct nodes half[2] = {between(FINE, lo, (lo + hi) / 2),
                            between(FINE, (lo + hi) / 2, hi)};
    double before[2 * FINE] = {0}, now[2 * FINE];
    for (int k = 0; k < 3; k++) {
        r.norm[k] = r.a[k] = 0;
        for (int i = 0; i < 2 * FINE; i++) {
            double t = half[i / FINE].x[i % FINE], x = t - hi;
            double g = half[i / FINE].w[i % FINE] * exp(near2 - t * t);
            double next = 1;
            if (k > 0)
                next = (x - r.a[k - 1]) * now[i] - r.b[k - 1] * before[i];
            before[i] = k > 0 ? now[i] : 0;
            now[i] = next;
            r.norm[k] += g * next * next;
            r.a[k] += g * x * next * next;
        }
        r.a[k] /= r.norm[k];
        r.b[k] = k > 0 ? r.norm[k] / r.norm[k - 1] : 0;
    }
    return r;
}

static struct rule rule_of(double near, double far)
{
    const double least = near < 0 ? -sqrt(near * near + 40) : -6.3;
    const double hi = fmin(near, 6.3), near2 = near < 0 ? near * near : 0;
    struct recurrence r = orthogonal(fmax(-far, least), hi, near2);
    const double *a = r.a, *b = r.b;
    // roots of the third polynomial, largest first
    double mean = (a[0] + a[1] + a[2]) / 3;
    double u = a[0] - mean, v = a[1] - mean, w = a[2] - mean;
    double p = u * v + u * w + v * w - b[1] - b[2];
    double q = b[1] * w + b[2] * u - u * v * w, reach = 2 * sqrt(-p / 3);
    double angle = acos(fmax(-1, fmin(1, 3 * q / (p * reach)))) / 3;
    struct rule n;
    for (int k = 0; k < 3; k++) {
        double x = mean + reach * cos(angle - 2 * pi * k / 3), t = x + hi;
        double p1 = x - a[0], p2 = (x - a[1]) * p1 - b[1];
        n.off[k] = near - t;
        n.weight[k] =
            exp(t * t - near2) /
            (1 / r.norm[0] + p1 * p1 / r.norm[1] + p2 * p2 / r.norm[2]);
    }
    return n;
}

// Where the product of the circular light and M_t is largest, by one step of
// Newton's from the plain product's centre; and its width there.  The series
// end where the shader's do: both choose nodes, not what is integrated.
static double centre_of(double apart, double w2, double l2, double *width)
{
    double d = apart * l2 / (w2 + l2), u = fmin(d * d, 6);
    double less = d * u * (1 / 6. - u * (1 / 120. - u / 5040));
    d += less * w2 / (fmax(1 - u / 2 + u * u / 24, 0) * w2 + l2);
    u = fmin(d * d, 6);
    double slope = fmax(1 - u / 2 + u * u / 24 - u * u * u / 720, 0);
    *width = sqrt(w2 * l2 / (slope * w2 + l2));
    return d;
}

static double mode(const struct exact_case *c, int t)
{
    double w = 2 * sqrt(2) * c->beta[t], l2 = c->lambda_j * c->lambda_j, width;
    double centre = 2 * c->alpha[t] - c->theta_o;
    double mu = c->theta_j + centre_of(centre - c->theta_j, w * w, l2, &width);
    width = fmin(width, pi / 3.3);
    double at = fmin(fabs(mu), pi / 2 + 4 * width), sign = mu < 0 ? -1 : 1;
    double near = fmin((pi / 2 - at) / width, 3), sum = 0;
    struct rule n = rule_of(near, (pi / 2 + at) / width);
    for (int i = 0; i < 3; i++) {
        double theta = sign * (at + width * (near - n.off[i]));
        double s = sin((theta - c->theta_j) / 2), b = (theta - centre) / w;
        if (fabs(theta) < pi / 2)
            sum += n.weight[i] * exp(-4 * s * s / l2 - b * b) *
                   azimuth(c, t, theta);
    }
    return sum * width / (sqrt(pi) * w);
}

void best_double_modes(const struct exact_case *c, double out[EXACT_MODES])
{
    for (int t = 0; t < EXACT_MODES; t++)
        out[t] = mode(c, t);
}
