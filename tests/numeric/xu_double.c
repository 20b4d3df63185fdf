// xu_double.c - see the header.  Nothing here is shared with the renderer but
// the struct of inputs, so that a slip in one is seen by the other.
#include "tests/numeric/xu_double.h"

#include <math.h>
#include <stddef.h>

static const double pi = 3.14159265358979323846;

// 16-point Gauss-Legendre, positive half.
static const double gl_x[8] = {0.0950125098376374402, 0.2816035507792589132,
                               0.4580167776572273863, 0.6178762444026437484,
                               0.7554044083550030339, 0.8656312023878317439,
                               0.9445750230732325761, 0.9894009349916499326};
static const double gl_w[8] = {0.1894506104550684963, 0.1826034150449235889,
                               0.1691565193950025382, 0.1495959888165767321,
                               0.1246289712555338720, 0.0951585116824927848,
                               0.0622535239386478929, 0.0271524594117540949};

struct lobes { // of one theta_d: N_TT and N_TRT as circular Gaussians
    double b_tt, l_tt;
    int count; // of TRT lobes
    double b[3], mu[3], l[3];
};

struct azimuth {
    double eta, q0; // index and its F_0
    double cd, sd;  // theta_d
    double eta1;    // eta'
    double s;       // sigma_a'
};

// e^{-k} I_0(k) from its definition; the integrand is periodic and smooth, so
// equal steps converge exponentially once they resolve the peak.
static double i0e(double k)
{
    double reach = k > 40 ? acos(fmax(-1, 1 - 40 / k)) : pi;
    int n = k > 40 ? 200 : 100;
    if (reach >= pi) {
        double sum = 0.5 * (1 + exp(-2 * k));
        for (int i = 1; i < n; i++)
            sum += exp(k * (cos(pi * i / n) - 1));
        return sum / n;
    }
    double sum = 0.5;
    for (int i = 1; i <= n; i++)
        sum += exp(k * (cos(reach * i / n) - 1));
    return sum * reach / n / pi;
}

// Integral over a period of the product of two circular Gaussians of Xu widths
// l1 and l2 whose centres are d apart.
static double gauss_product(double d, double k1, double l2)
{
    double k2 = 2 / (l2 * l2);
    double k =
        sqrt((k1 - k2) * (k1 - k2) + 4 * k1 * k2 * cos(d / 2) * cos(d / 2));
    double less = -4 * k1 * k2 * sin(d / 2) * sin(d / 2) / (k + k1 + k2);
    return 2 * pi * i0e(k) * exp(less);
}

// Schlick 1994 as Xu 2011, section 4.2.1 uses it.
static double fresnel(const struct azimuth *z, double h)
{
    return z->q0 + (1 - z->q0) * pow(1 - z->cd * sqrt(fmax(0, 1 - h * h)), 5);
}

static struct azimuth azimuth_at(double eta, double sigma_a, double theta_d)
{
    struct azimuth z = {.eta = eta, .cd = cos(theta_d), .sd = sin(theta_d)};
    z.q0 = (1 - eta) * (1 - eta) / ((1 + eta) * (1 + eta));
    z.eta1 = sqrt(eta * eta - z.sd * z.sd) / z.cd;
    z.s = sigma_a / sqrt(1 - z.sd * z.sd / (eta * eta));
    return z;
}

// Integrals over h of (1-F)^2 F^r times the Taylor polynomial of exp(-2 s' cos)
// with s' = s (TT, r = 0) or 2 s (TRT, r = 1), halved: eq 19 and 23.
static double energy(const struct azimuth *z, int r)
{
    double s = z->s * (1 + r), e2 = z->eta1 * z->eta1;
    double a0 = exp(-2 * s), a2 = a0 * s / e2;
    double a4 = a0 * (s / 4 + s * s / 2) / (e2 * e2), sum = 0;
    for (int i = 0; i < 16; i++) {
        double x = i < 8 ? gl_x[i] : -gl_x[i - 8], w = gl_w[i % 8];
        for (int panel = 0; panel < 4; panel++) { // h = sin g, 0 < g < pi/2
            double g = pi / 8 * (panel + 0.5 + x / 2), h = sin(g);
            double f = fresnel(z, h);
            sum += w * pi / 16 * cos(g) * (1 - f) * (1 - f) * (r ? f : 1) *
                   (a0 + a2 * h * h + a4 * h * h * h * h);
        }
    }
    return sum; // twice the half
}

static double n_trt(const struct azimuth *z, double h)
{
    double f = fresnel(z, h), e = z->eta1;
    double slope = 4 / sqrt(e * e - h * h) - 2 / sqrt(1 - h * h);
    double t = exp(-2 * z->s * sqrt(1 - h * h / (e * e)));
    if (fabs(slope) < 2e-6)
        slope = 2e-6;
    return 0.5 / fabs(slope) * (1 - f) * (1 - f) * f * t * t;
}

static void set_tt(const struct azimuth *z, struct lobes *out)
{
    double f = fresnel(z, 0), e = z->eta1;
    out->b_tt = e / (4 * (e - 1)) * (1 - f) * (1 - f) * exp(-2 * z->s);
    out->l_tt = energy(z, 0) / (sqrt(pi) * out->b_tt);
}

static void set_trt(const struct azimuth *z, const struct exact_case *c,
                    struct lobes *out)
{
    double e = z->eta1, whole = energy(z, 1), peak = n_trt(z, 0);
    double w = c->w_c;
    if (e < 2) {
        if (e >= sqrt(2))
            peak += 2 * n_trt(z, e * sqrt(1 - e * e / 4));
        double h = sqrt((4 - e * e) / 3);
        double at = fabs(4 * asin(h / e) - 2 * asin(h));
        at = fmax(at, 1e-6);
        double away = 1 - exp(2 * (cos(at) - 1) / (w * w));
        double b2 = peak * away * away;
        double b1 = (whole - b2 * sqrt(pi) * at) / (2 * sqrt(pi) * w);
        b1 = fmax(b1, 0);
        out->count = 3;
        out->b[0] = out->b[1] = b1;
        out->b[2] = b2;
        out->mu[0] = at;
        out->mu[1] = -at;
        out->mu[2] = 0;
        out->l[0] = out->l[1] = w;
        out->l[2] = at;
        return;
    }
    double l3 = whole / (sqrt(pi) * peak);
    double t = fmin(1, (e - 2) / c->delta_eta);
    t = t * t * (3 - 2 * t);
    out->count = 1;
    out->l[0] = w + (l3 - w) * t;
    out->b[0] = peak * l3 / out->l[0];
    out->mu[0] = 0;
}

// Int g^c(x) N_R(Phi - x) dx with N_R from eq 13: panels of a width or less,
// one edge on the fold of |cos| at Phi - x = +-pi.
static double inner_r(const struct azimuth *z, double k, double phi)
{
    double fold = remainder(phi - pi, 2 * pi), sum = 0;
    double reach = fmin(pi, 8 * sqrt(2 / k));
    int n = (int)ceil(reach / fmin(0.4, 1.5 * sqrt(2 / k)));
    for (int side = 0; side < 2; side++) {
        double a = side ? fold : -reach, b = side ? reach : fold;
        a = fmax(a, -reach);
        b = fmin(b, reach);
        double step = (b - a) / (2 * n);
        for (int p = 0; p < 2 * n && step > 0; p++)
            for (int i = 0; i < 16; i++) {
                double x = i < 8 ? gl_x[i] : -gl_x[i - 8];
                x = a + step * (p + 0.5 + x / 2);
                double u = fabs(cos((phi - x) / 2));
                double h = sin((phi - x) / 2);
                sum += gl_w[i % 8] * step / 2 * exp(k * (cos(x) - 1)) / 4 * u *
                       fresnel(z, h);
            }
    }
    return sum;
}

static double inner(const struct exact_case *c, int mode, double theta_i)
{
    double theta_d = (c->theta_o - theta_i) / 2, phi = c->phi_o - c->phi_j;
    double k = 2 * cos(theta_i) * cos(c->theta_j) / (c->lambda_j * c->lambda_j);
    double eta = c->eta;
    struct lobes n;
    if (mode == EXACT_TRT && c->a != 1) { // eq 24 to 26
        double e1 = 2 * (eta - 1) * c->a * c->a - eta + 2;
        double e2 = 2 * (eta - 1) / (c->a * c->a) - eta + 2;
        // The mean of cos(x) under g^c, from two products with a flat partner.
        double mean = 0, all = 0, reach = fmin(pi, 9 * sqrt(2 / k));
        for (int i = 0; i < 4000; i++) {
            double x = reach * (i + 0.5) / 4000;
            double g = exp(k * (cos(x) - 1));
            mean += g * cos(x);
            all += g;
        }
        eta =
            ((e1 + e2) + mean / all * cos(c->phi_o + c->phi_j) * (e1 - e2)) / 2;
    }
    struct azimuth z = azimuth_at(eta, c->sigma_a, theta_d);
    if (mode == EXACT_R)
        return inner_r(&z, k, phi);
    if (mode == EXACT_TT) {
        set_tt(&z, &n);
        return n.b_tt > 0 ? n.b_tt * gauss_product(phi - pi, k, n.l_tt) : 0;
    }
    set_trt(&z, c, &n);
    double sum = 0;
    for (int i = 0; i < n.count; i++)
        if (n.b[i] > 0)
            sum += n.b[i] * gauss_product(phi - n.mu[i], k, n.l[i]);
    return sum;
}

static double integrand(const struct exact_case *c, int mode, double theta_i)
{
    double ci = cos(theta_i), cd = cos((c->theta_o - theta_i) / 2);
    if (ci < 1e-9)
        return 0;
    return ci * ci / (cd * cd) * inner(c, mode, theta_i);
}

// Gaussian times the line through (x0, f0), (x1, f1), over [x0, x1].
static double segment(double mu, double l, const double x[2], const double f[2])
{
    double t0 = (x[0] - mu) / l, t1 = (x[1] - mu) / l, width = x[1] - x[0];
    if (width < 1e-3 * l) {
        double t = (t0 + t1) / 2;
        return l * exp(-t * t) * (t1 - t0) * (f[0] + f[1]) / 2;
    }
    double d = t0 > 0   ? erfc(t0) - erfc(t1)
               : t1 < 0 ? erfc(-t1) - erfc(-t0)
                        : erf(t1) - erf(t0);
    double e = l * sqrt(pi) / 2 * d;
    double j = l * l / 2 * (exp(-t0 * t0) - exp(-t1 * t1));
    double w1 = (j - (x[0] - mu) * e) / width;
    return (e - w1) * f[0] + w1 * f[1];
}

static double clip(double x, double lo, double hi)
{
    return fmin(fmax(x, lo), hi);
}

double xu_double_linear(const double mu_l[2], int m, bool fine,
                        xu_double_function *function, const void *self)
{
    double half = pi / 2, mu = mu_l[0], l = mu_l[1];
    double a = mu - (m - 2) * l / 2, b = mu + (m - 2) * l / 2;
    if (fine) {
        double w = fmin(4, sqrt((m - 2) / 2.0));
        a = clip(mu - w * l, -half, fmax(-half, half - 2 * l));
        b = clip(mu + w * l, fmin(half, -half + 2 * l), half);
    }
    double x[2] = {-half, -half}, f[2] = {0, 0}, sum = 0;
    for (int s = 0; s < m; s++) {
        x[1] = m == 2 ? mu : a + (b - a) * s / (m - 2);
        x[1] = s == m - 1 ? half : clip(x[1], -half, half);
        f[1] = s == m - 1 ? 0 : function(self, x[1]);
        sum += segment(mu, l, x, f);
        x[0] = x[1];
        f[0] = f[1];
    }
    return sum;
}

struct of_mode {
    const struct exact_case *c;
    int mode;
};

static double of_mode(const void *self, double theta_i)
{
    const struct of_mode *o = self;
    return integrand(o->c, o->mode, theta_i);
}

void xu_double_modes(const struct exact_case *c, int m, bool fine,
                     double out[EXACT_MODES])
{
    double lj = c->lambda_j;
    for (int t = 0; t < EXACT_MODES; t++) {
        double l1 = 2 * sqrt(2) * c->beta[t],
               mu1 = 2 * c->alpha[t] - c->theta_o;
        double sum2 = l1 * l1 + lj * lj, l = l1 * lj / sqrt(sum2);
        double mu = (mu1 * lj * lj + c->theta_j * l1 * l1) / sum2;
        double apart = mu1 - c->theta_j;
        double scale = exp(-apart * apart / sum2) / (sqrt(pi) * l1);
        const struct of_mode o = {c, t};
        out[t] =
            scale * xu_double_linear((double[2]){mu, l}, m, fine, of_mode, &o);
    }
}

void xu_double_azimuth(const struct exact_case *c, int mode,
                       const double cos_d_eta_trt[2], double *phi, int count)
{
    double eta = mode == EXACT_TRT ? cos_d_eta_trt[1] : c->eta;
    struct azimuth z = azimuth_at(eta, c->sigma_a, acos(cos_d_eta_trt[0]));
    struct lobes n = {0};
    if (mode == EXACT_TT) {
        set_tt(&z, &n);
        n.count = 1;
        n.b[0] = n.b_tt;
        n.mu[0] = pi;
        n.l[0] = n.l_tt;
    } else if (mode == EXACT_TRT) {
        set_trt(&z, c, &n);
    }
    for (int k = 0; k < count; k++) {
        double sum = mode == EXACT_R ? fabs(cos(phi[k] / 2)) / 4 *
                                           fresnel(&z, sin(phi[k] / 2))
                                     : 0;
        for (int i = 0; i < n.count; i++) {
            double x = remainder(phi[k] - n.mu[i], 2 * pi) / n.l[i];
            if (n.b[i] > 0)
                sum += n.b[i] * exp(-x * x);
        }
        phi[k] = sum;
    }
}
