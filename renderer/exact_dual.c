// exact_dual.c - the integrals of dual scattering by quadrature, nothing
// separated and nothing fitted.
//
// As in exact.c the sum over roots of eq 9 becomes an integral over
// h = sin gamma.  What is asked of the azimuth are then weights of phi(h):
// |phi| for the share that goes forward, a half circle for N^G; for TRT both
// are convolved with the smoothing Gaussian beforehand, in a fine table.  Eq 32
// and 33: the double integral over phi_o and phi_d of N is 2 Int_0^pi phi N
// dphi.
#include "renderer/exact_dual.h"

#include <math.h>
#include <stdlib.h>

#include "protocol/bytes.h"
#include "renderer/quadrature.h"

static const double pi = 3.14159265358979323846;

enum {
    COLUMNS = 512, // of cos theta_d
    STEPS = 2048,  // of phi over [0, pi]
    GAMMAS = 32    // panels of gamma, for integrals without an edge
};

struct exact_dual {
    struct exact_case c;
    double eta_path; // index in TRT's paths
    double kappa_c;
    double lobe[STEPS + 1];    // smoothing Gaussian, normalised
    double within[STEPS + 1];  // its integral from 0
    double forward[STEPS + 1]; // |phi|/pi smoothed
    double energy[2][EXACT_MODES][COLUMNS + 1]; // forward, all; of cos theta_d
};

// --- the smoothing Gaussian -------------------------------------------------

static double lobe(const struct exact_dual *e, double x)
{
    double s = sin(x / 2);
    return exp(-2 * e->kappa_c * s * s) / (2 * pi * exact_i0e(e->kappa_c));
}

// Cubic Hermite through values and slopes at x = i pi / STEPS, 0 <= x <= pi.
static double hermite(const double *value, const double *slope, double scale,
                      double x)
{
    double at = fmin(x / pi, 1) * STEPS, h = pi / STEPS * scale;
    int i = (int)fmin(at, STEPS - 1);
    double t = at - i, u = 1 - t;
    return u * u * (1 + 2 * t) * value[i] + t * t * (1 + 2 * u) * value[i + 1] +
           h * t * u * (u * slope[i] - t * slope[i + 1]);
}

// Integral of the Gaussian from 0 to x, any x.
static double within(const struct exact_dual *e, double x)
{
    double turns = round(x / (2 * pi)), y = x - 2 * pi * turns;
    return turns + copysign(hermite(e->within, e->lobe, 1, fabs(y)), y);
}

static void fill_lobe(struct exact_dual *e)
{
    static const double zero[STEPS + 1];
    double w;
    for (int i = 0; i <= STEPS; i++)
        e->lobe[i] = lobe(e, pi * i / STEPS);
    for (int i = 0; i < STEPS; i++) {
        e->within[i + 1] = e->within[i];
        for (int k = 0; k < 8; k++) {
            double x =
                quadrature_node(pi * i / STEPS, pi * (i + 1) / STEPS, k, &w);
            e->within[i + 1] += w * lobe(e, x);
        }
    }
    // d/dphi of the smoothed |phi| is 2 P(wrap(phi - y) > 0) - 1.
    for (int i = 0; i < STEPS; i++) {
        e->forward[i + 1] = e->forward[i];
        for (int k = 0; k < 8; k++) {
            double x =
                quadrature_node(pi * i / STEPS, pi * (i + 1) / STEPS, k, &w);
            double ahead = within(e, x) + within(e, pi - x);
            e->forward[i + 1] += w * (2 * ahead - 1) / pi;
        }
    }
    // |phi| and |pi - phi| together are pi everywhere, so 1/2 at pi/2.
    double lift = 0.5 - hermite(e->forward, zero, 0, pi / 2);
    for (int i = 0; i <= STEPS; i++)
        e->forward[i] += lift;
}

// --- the section at one theta_d ---------------------------------------------
struct section {
    const struct exact_dual *e;
    int mode;
    double cos_d;
    double bend;      // 1/eta' of the path
    double bend_real; // 1/eta' of absorption
    double sigma;
};

static struct section section_at(const struct exact_dual *e, int mode,
                                 double cos_d)
{
    double c = fmax(cos_d, 1e-9), eta = e->c.eta, s2 = 1 - c * c;
    double path = mode == EXACT_TRT ? e->eta_path : eta;
    return (struct section){e,
                            mode,
                            c,
                            c / sqrt(path * path - s2),
                            c / sqrt(eta * eta - s2),
                            e->c.sigma_a / sqrt(1 - s2 / (eta * eta))};
}

static double turn(const struct section *s, double gamma) // eq 8
{
    return 2 * s->mode * asin(sin(gamma) * s->bend) - 2 * gamma + pi * s->mode;
}

// A cos gamma (eq 10).
static double amount(const struct section *s, double gamma)
{
    double f = exact_fresnel(s->e->c.eta, s->cos_d * cos(gamma));
    double x = sin(gamma) * s->bend_real;
    if (s->mode == EXACT_R)
        return cos(gamma) * f;
    return cos(gamma) * (1 - f) * (1 - f) * (s->mode == EXACT_TRT ? f : 1) *
           exp(-2 * s->mode * s->sigma * sqrt(1 - x * x));
}

// How much of direction phi counts as forward, 0..1.
static double forward(const struct section *s, double phi)
{
    double x = fabs(remainder(phi, 2 * pi));
    if (s->mode != EXACT_TRT)
        return x / pi;
    double at =
        fmin(x / pi, 1) * STEPS; // curvature 2 lobe / pi: linear will do
    int i = (int)fmin(at, STEPS - 1);
    return s->e->forward[i] +
           (at - i) * (s->e->forward[i + 1] - s->e->forward[i]);
}

// out = Int N dphi, its forward part (weight |phi|/pi, eq 33).
static void energies(const struct section *s, double *all, double *ahead)
{
    double w;
    *all = *ahead = 0;
    for (int panel = 0; panel < GAMMAS; panel++)
        for (int i = 0; i < 8; i++) {
            double g = quadrature_node(pi / 2 * panel / GAMMAS,
                                       pi / 2 * (panel + 1) / GAMMAS, i, &w);
            double a = w * amount(s, g);
            *all += a;
            *ahead += a * forward(s, turn(s, g));
        }
}

struct exact_dual *exact_dual_create(const struct exact_case *c)
{
    struct exact_dual *e = bytes_zalloc(1, sizeof *e);
    double aa = c->a * c->a;
    e->c = *c;
    // Mean of eq 24 over all azimuths.
    e->eta_path = 1 + (c->eta - 1) * (aa + 1 / aa - 1);
    e->kappa_c = 2 / (c->w_c * c->w_c);
    fill_lobe(e);
    for (int t = 0; t < EXACT_MODES; t++)
        for (int i = 0; i <= COLUMNS; i++) {
            struct section s = section_at(e, t, (double)i / COLUMNS);
            energies(&s, &e->energy[1][t][i], &e->energy[0][t][i]);
        }
    return e;
}

void exact_dual_destroy(struct exact_dual *e)
{
    free(e);
}

// Lagrange's polynomial through six neighbours: smooth enough for an adaptive
// integration to see no seams.
static double energy(const struct exact_dual *e, int whole, int t, double cos_d)
{
    static const double under[6] = {-120, 24, -12, 12, -24, 120};
    const double *v = e->energy[whole][t];
    double at = fmin(fmax(cos_d, 0), 1) * COLUMNS, left[6], right[6], sum = 0;
    int i = (int)fmin(fmax(floor(at) - 2, 0), COLUMNS - 5);
    double x = at - i, product = 1;
    for (int k = 0; k < 6; k++, product *= x - (k - 1))
        left[k] = product;
    product = 1;
    for (int k = 5; k >= 0; k--, product *= x - (k + 1))
        right[k] = product;
    for (int k = 0; k < 6; k++)
        sum += v[i + k] * left[k] * right[k] / under[k];
    return sum;
}

// --- means over a half space (eq 32) ----------------------------------------
struct bounce {
    const struct exact_dual *e;
    int mode;
    bool whole;
    double theta; // of the illumination
};

static double bounce_at(void *self, double theta_o)
{
    const struct bounce *b = self;
    double width = 2 * b->e->c.beta[b->mode];
    double z = (theta_o + b->theta - 2 * b->e->c.alpha[b->mode]) / width;
    double cd = cos((theta_o - b->theta) / 2);
    return exp(-z * z / 2) * cos(theta_o) * cos(b->theta) / (cd * cd) *
           energy(b->e, b->whole, b->mode, cd);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorted edges within +-pi/2.
static void fit_edges(double *edge, int count)
{
    for (int i = 0; i < count; i++)
        edge[i] = fmin(fmax(edge[i], -pi / 2), pi / 2);
    qsort(edge, (size_t)count, sizeof *edge, ascending);
}

// The lobe, and cos cos / cos^2 theta_d, which near grazing has a peak of its
// own, as wide as the light is away from pi/2.
static double bounces(const struct exact_dual *e, int t, bool whole,
                      double theta)
{
    static const double reach[7] = {-9, -4, -1.5, 0, 1.5, 4, 9};
    static const double far[6] = {0, 1, 3, 10, 30, 100};
    struct bounce b = {e, t, whole, theta};
    double edge[14], width = 2 * e->c.beta[t];
    for (int i = 0; i < 7; i++)
        edge[i] = 2 * e->c.alpha[t] - theta + width * reach[i];
    double lo = fmax(edge[0], -pi / 2), hi = fmin(edge[6], pi / 2);
    double grazing = pi / 2 - fabs(theta);
    for (int i = 0; i < 6; i++) {
        double x = copysign(pi / 2 - grazing * far[i], -theta);
        edge[7 + i] = fmin(fmax(x, lo), hi);
    }
    edge[13] = -theta;
    fit_edges(edge, 14);
    return exact_integral(bounce_at, &b, edge, 13, 1e-8) /
           (width * sqrt(2 * pi));
}

void exact_dual_mean(const struct exact_dual *e, double theta,
                     struct exact_dual_mean *out)
{
    struct exact_dual_mean m = {0};
    theta = fmin(fmax(theta, 1e-6 - pi / 2), pi / 2 - 1e-6);
    for (int t = 0; t < EXACT_MODES; t++) {
        double alpha = e->c.alpha[t], beta2 = e->c.beta[t] * e->c.beta[t];
        double f = bounces(e, t, false, theta);
        double b = fmax(bounces(e, t, true, theta) - f, 0);
        m.a_f += f;
        m.a_b += b;
        m.alpha_f += f * alpha;
        m.alpha_b += b * alpha;
        m.beta2_f += f * beta2;
        m.beta2_b += b * beta2;
    }
    m.alpha_f /= m.a_f;
    m.beta2_f /= m.a_f;
    m.alpha_b /= m.a_b;
    m.beta2_b /= m.a_b;
    // A pile of layers, each a_f through and a_b back: its reflectance R obeys
    // R = a_b + a_f^2 R / (1 - a_b R); all but the first bounce is A_b.
    double x = m.a_f * m.a_f, y = 1 - x, q = 1 + m.a_b * m.a_b - x;
    double pile = 2 * m.a_b / (q + sqrt(fmax(0, q * q - 4 * m.a_b * m.a_b)));
    m.A_b = x * pile / (1 - m.a_b * pile);
    // Sums over the paths with one and with three turns (Zinke 2008, 3.2.2).
    double r = m.a_b * m.a_b / (y * y);
    double nb = (1 + 3 * r) / (1 + r);
    double nf = 2 / y * (1 + r * (1 + 2 * x)) / (1 + r);
    m.delta_b = 2 * (nb * m.alpha_b + nf * m.alpha_f);
    m.sigma_b = 2 * sqrt(nb * m.beta2_b + nf * m.beta2_f);
    *out = m;
}

// --- half circles (eq 28) ---------------------------------------------------
// Integral of A cos gamma between two gammas.
static double between(const struct section *s, double from, double to)
{
    enum { PANELS = GAMMAS / 4 };
    double sum = 0, w;
    for (int panel = 0; panel < PANELS && from < to; panel++)
        for (int i = 0; i < 8; i++) {
            double g = quadrature_node(
                from + (to - from) * panel / PANELS,
                from + (to - from) * (panel + 1) / PANELS, i, &w);
            sum += w * amount(s, g);
        }
    return sum;
}

// R, TT: the gamma whose light leaves at |phi| = x, which is monotone.
static double gamma_at(const struct section *s, double x)
{
    double lo = 0, hi = pi / 2;
    if (s->mode == EXACT_R)
        return fmin(x, pi) / 2;
    for (int i = 0; i < 60; i++) {
        double g = (lo + hi) / 2;
        *(turn(s, g) > x ? &lo : &hi) = g;
    }
    return (lo + hi) / 2;
}

// All light that leaves within from < |phi| < to.
static double ring(const struct section *s, double from, double to)
{
    double a = gamma_at(s, from), b = gamma_at(s, to);
    return between(s, fmin(a, b), fmax(a, b));
}

static double half_circle(const struct section *s, double phi)
{
    double x = fabs(remainder(phi, 2 * pi)), sum = 0, w;
    if (s->mode != EXACT_TRT) {
        if (x < pi / 2)
            return (ring(s, 0, pi / 2 - x) + ring(s, 0, pi / 2 + x)) / (2 * pi);
        return (ring(s, x - pi / 2, pi) + ring(s, 1.5 * pi - x, pi)) / (2 * pi);
    }
    int panels = (int)fmin(8 + 8 / s->e->c.w_c, 1000);
    for (int panel = 0; panel < panels; panel++)
        for (int i = 0; i < 8; i++) {
            double g = quadrature_node(pi / 2 * panel / panels,
                                       pi / 2 * (panel + 1) / panels, i, &w);
            double at = turn(s, g);
            double seen =
                within(s->e, x - at + pi / 2) - within(s->e, x - at - pi / 2) +
                within(s->e, x + at + pi / 2) - within(s->e, x + at - pi / 2);
            sum += w * amount(s, g) * seen;
        }
    return sum / (2 * pi);
}

void exact_dual_half(const struct exact_dual *e, double theta_d, double phi,
                     double out[EXACT_MODES])
{
    for (int t = 0; t < EXACT_MODES; t++) {
        struct section s = section_at(e, t, cos(theta_d));
        out[t] = half_circle(&s, phi);
    }
}

// --- global and local integrals (eq 27, 29) ---------------------------------
struct spread {
    const struct exact_dual *e;
    const struct exact_case *c;
    int mode;
    bool mean;
    double lift; // of the mean over phi_o, added to N^G
    double sigma_f;
};

static double gauss(double x, double width)
{
    return exp(-x * x / (width * width)) / (sqrt(pi) * width);
}

static double global_at(void *self, double theta_i)
{
    const struct spread *s = self;
    const struct exact_case *c = s->c;
    double theta_d = (c->theta_o - theta_i) / 2, cd = cos(theta_d);
    double width = 2 * sqrt(2) * c->beta[s->mode];
    double weight = gauss(theta_i - c->theta_j, s->sigma_f) *
                    gauss(theta_i + c->theta_o - 2 * c->alpha[s->mode], width);
    if (weight == 0)
        return 0;
    double n = s->lift * energy(s->e, 1, s->mode, cd) / (2 * pi);
    if (!s->mean) {
        struct section at = section_at(s->e, s->mode, cd);
        n += half_circle(&at, c->phi_o - c->phi_j);
    }
    return weight * cos(theta_i) / (cd * cd) * n;
}

// S_back without its azimuth, times cos theta_i (Zinke 2008, eq 10 and 15).
static double back_at(const struct spread *s, double theta_i)
{
    const struct exact_case *c = s->c;
    double theta_d = (c->theta_o - theta_i) / 2, cd = cos(theta_d);
    struct exact_dual_mean m;
    exact_dual_mean(s->e, -theta_d, &m);
    return m.A_b * cos(theta_i) / (cd * cd) *
           gauss(theta_i + c->theta_o - m.delta_b, sqrt(2) * m.sigma_b);
}

static double local_at(void *self, double theta_i)
{
    const struct spread *s = self;
    double away = fabs(remainder(s->c->phi_o - s->c->phi_j, 2 * pi));
    double weight = gauss(theta_i - s->c->theta_j, s->sigma_f) *
                    (s->mean ? 1 / (2 * pi) : (pi - away) / (pi * pi));
    return weight < 1e-30 ? 0 : weight * back_at(s, theta_i);
}

// Integral of exp(kappa (cos t - 1)) from a to b, -pi/2 <= a, b <= 3 pi/2.
static double arc(double kappa, double a, double b)
{
    double reach = 9 * sqrt(2 / kappa), sum = 0, w;
    a = fmax(a, -reach);
    b = fmin(b, reach);
    for (int panel = 0; panel < 32 && a < b; panel++)
        for (int i = 0; i < 8; i++) {
            double t = quadrature_node(a + (b - a) * panel / 32,
                                       a + (b - a) * (panel + 1) / 32, i, &w);
            double h = sin(t / 2);
            sum += w * exp(-2 * kappa * h * h);
        }
    return sum;
}

static double direct_at(void *self, double theta_i)
{
    const struct spread *s = self;
    const struct exact_case *c = s->c;
    double h = sin((theta_i - c->theta_j) / 2) / c->lambda_j;
    double ci = cos(theta_i), weight = exp(-4 * h * h) * ci / pi;
    double kappa =
        2 * ci * fmax(0, cos(c->theta_j)) / (c->lambda_j * c->lambda_j);
    if (weight < 1e-30)
        return 0;
    double phi = fabs(remainder(c->phi_o - c->phi_j, 2 * pi));
    double lit = s->mean ? pi * exact_i0e(kappa)
                         : arc(fmax(kappa, 1e-9), phi - pi / 2, phi + pi / 2);
    return weight * lit * back_at(s, theta_i);
}

// Edges for the product of a Gaussian about mu and one about `other`.
static double over_product(exact_integrand *f, struct spread *s,
                           const double lobe_at[2], const double width[2])
{
    static const double reach[7] = {-6.5, -3, -1, 0, 1, 3, 6.5};
    double w2[2] = {width[0] * width[0], width[1] * width[1]};
    double l = sqrt(w2[0] * w2[1] / (w2[0] + w2[1])), edge[14];
    double mu = (lobe_at[0] * w2[1] + lobe_at[1] * w2[0]) / (w2[0] + w2[1]);
    for (int i = 0; i < 7; i++)
        edge[i] = mu + l * reach[i];
    double lo = fmax(edge[0], -pi / 2), hi = fmin(edge[6], pi / 2);
    for (int i = 0; i < 7; i++)
        edge[i] = fmin(fmax(edge[i], lo), hi);
    fit_edges(edge, 7);
    return lo < hi ? exact_integral(f, s, edge, 6, 1e-7) : 0;
}

// Width and place of S_back move with theta_i: wide enough for all of them.
static double over_back(exact_integrand *f, struct spread *s, double width)
{
    static const double reach[5] = {-6.5, -2, 0, 2, 6.5};
    static const double spot[8] = {-1, -.3, -.1, -.03, .03, .1, .3, 1};
    double lo = fmax(s->c->theta_j - 6.5 * width, -pi / 2);
    double hi = fmin(s->c->theta_j + 6.5 * width, pi / 2), edge[13];
    for (int i = 0; i < 5; i++)
        edge[i] = s->c->theta_j + width * reach[i];
    for (int i = 0; i < 8; i++)
        edge[5 + i] = fmin(fmax(spot[i] - s->c->theta_o, lo), hi);
    fit_edges(edge, 13);
    return exact_integral(f, s, edge, 12, 1e-6);
}

void exact_dual_multiple(const struct exact_dual *e, const struct exact_case *c,
                         double sigma_f, bool mean,
                         double out[EXACT_DUAL_OUTPUTS])
{
    // Far from its lobe N^G_TRT is less than what its table's interpolation
    // leaves of noise, after which an adaptive rule would run for seconds: a
    // part of the mean is added to the integrand and taken off the result.
    const double lift = 1e-3;
    struct spread s = {e, c, 0, mean, 1, sigma_f};
    for (s.mode = 0; s.mode < EXACT_MODES; s.mode++) {
        const double at[2] = {c->theta_j, 2 * c->alpha[s.mode] - c->theta_o};
        const double width[2] = {sigma_f, 2 * sqrt(2) * c->beta[s.mode]};
        s.mean = true;
        s.lift = 1;
        out[s.mode] = over_product(global_at, &s, at, width);
        if (mean)
            continue;
        s.mean = false;
        s.lift = lift;
        out[s.mode] = fmax(
            over_product(global_at, &s, at, width) - lift * out[s.mode], 0);
    }
    s.mean = mean;
    out[EXACT_DUAL_ML] = over_back(local_at, &s, sigma_f);
    out[EXACT_DUAL_MLD] = over_back(direct_at, &s, c->lambda_j);
}
