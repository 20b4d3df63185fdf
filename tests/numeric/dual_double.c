// dual_double.c - see the header.
#include "tests/numeric/dual_double.h"

#include <math.h>

#include "tests/numeric/xu_double.h"

static const double pi = 3.14159265358979323846;

static double gauss(double x, double width)
{
    return exp(-x * x / (width * width)) / (sqrt(pi) * width);
}

// --- best -------------------------------------------------------------------
static double polynomial(const double *row, int powers, double x)
{
    double v = 0;
    while (powers > 0)
        v = v * x + row[--powers];
    return v;
}

static double wave(const double *row, int harmonics, double phi)
{
    double v = row[0];
    for (int k = 1; k < harmonics; k++)
        v += row[k] * cos((2 * k - 1) * phi);
    return v;
}

static double series(const struct dual_tables *t, double eta, int mode,
                     int channel, const double at[2]) // cos theta_d, Phi
{
    const struct dual_series *s = dual_tables_series(t);
    double c = at[0], x = 2 * eta * c / sqrt(eta * eta - 1 + c * c) - 1, v = 0;
    for (int m = 0; m < DUAL_WAVES_R && mode == 0; m++)
        v += wave(s->wave_r[m], DUAL_HARMONICS, at[1]) *
             polynomial(s->r[m], DUAL_POWERS, x);
    for (int m = 0; m < DUAL_WAVES_TT && mode == 1; m++)
        v += wave(s->wave_tt[m], DUAL_HARMONICS, at[1]) *
             polynomial(s->tt[channel][m], DUAL_POWERS, x);
    for (int m = 0; m < DUAL_WAVES_TRT && mode == 2; m++)
        v += wave(s->wave_trt[m], DUAL_HARMONICS_TRT, at[1]) *
             polynomial(s->trt[channel][m], DUAL_POWERS_TRT, x);
    v = fmax(v, 0);
    if (mode == 2)
        v *= dual_azimuth_schlick(eta, c);
    return mode ? v * c * c : v;
}

static double global_best(const struct dual_tables *t,
                          const struct exact_case *c, const double sigma_f[3],
                          int mode, int channel)
{
    static const double x[5] = {-0.9061798459386640, -0.5384693101056831, 0,
                                0.5384693101056831, 0.9061798459386640};
    static const double w[5] = {0.2369268850561891, 0.4786286704993665,
                                0.5688888888888889, 0.4786286704993665,
                                0.2369268850561891};
    double s2 = (sigma_f[0] * sigma_f[0] + sigma_f[1] * sigma_f[1] +
                 sigma_f[2] * sigma_f[2]) /
                3;
    double w2 = 8 * c->beta[mode] * c->beta[mode], sum[3] = {0};
    double apart = 2 * c->alpha[mode] - c->theta_o - c->theta_j;
    double mu = c->theta_j + apart * s2 / (w2 + s2);
    double l = sqrt(w2 * s2 / (w2 + s2));
    double from = (-pi / 2 - mu) / l, to = (pi / 2 - mu) / l;
    double lo = fmax(from, fmin(-1.985, to - 1));
    double hi = fmin(to, fmax(1.985, from + 1));
    for (int i = 0; i < 5; i++) {
        double z = (lo + hi) / 2 + (hi - lo) / 2 * x[i], theta = mu + l * z;
        double cd = cos((c->theta_o - theta) / 2);
        const double at[2] = {cd, c->phi_o - c->phi_j};
        double f = w[i] * (hi - lo) / 2 * exp(-z * z) / sqrt(pi) *
                   fmax(cos(theta), 0) / (cd * cd) *
                   series(t, c->eta, mode, channel, at);
        sum[0] += f;
        sum[1] += f * z;
        sum[2] += f * (z * z - 0.5);
    }
    double own2 = sigma_f[channel] * sigma_f[channel];
    double mu_own = c->theta_j + apart * own2 / (w2 + own2);
    double tilt = fmin(fmax(2 * (mu_own - mu) / l, -1), 1);
    double widen =
        fmin(own2 / (w2 + own2) * (w2 + s2) / s2 - 1, 1) + tilt * tilt / 2;
    return gauss(apart, sqrt(w2 + own2)) *
           fmax(sum[0] + tilt * sum[1] + widen * sum[2], 0);
}

static double local_best(const struct dual_tables *t,
                         const struct exact_case *c, double sigma_f,
                         int channel)
{
    enum { STEPS = 4000 };
    double sum = 0, away = fabs(remainder(c->phi_o - c->phi_j, 2 * pi));
    for (int i = 0; i < STEPS; i++) {
        double theta = pi * ((i + 0.5) / STEPS - 0.5);
        double d = (theta - c->theta_o) / 2;
        struct dual_mean m;
        dual_tables_mean(t, d, channel, &m);
        sum += gauss(theta - c->theta_j, sigma_f) * m.A_b *
               gauss(theta + c->theta_o - m.delta_b, sqrt(2) * m.sigma_b) *
               cos(theta) / (cos(d) * cos(d));
    }
    return sum * pi / STEPS * (pi - away) / (pi * pi);
}

// Integral of exp(kappa (cos t - 1)) over half a circle about phi.
static double half_lobe(double kappa, double phi)
{
    enum { STEPS = 200 };
    const double reach = kappa > 40 ? acos(1 - 40 / kappa) : pi;
    const double lo = fmax(phi - pi / 2, -reach);
    const double hi[2] = {fmin(phi + pi / 2, reach),
                          fmin(phi + pi / 2, 2 * pi + reach)};
    const double from[2] = {lo, fmax(phi - pi / 2, 2 * pi - reach)};
    double sum = 0;
    for (int part = 0; part < 2; part++) {
        const double step = fmax(hi[part] - from[part], 0) / STEPS;
        for (int i = 0; i < STEPS; i++) {
            const double h = sin((from[part] + (i + 0.5) * step) / 2);
            sum += step * exp(-2 * kappa * h * h);
        }
    }
    return sum;
}

double dual_double_glow(const struct dual_tables *t, const struct exact_case *c,
                        int channel)
{
    enum { STEPS = 400 };
    const double phi = fabs(remainder(c->phi_o - c->phi_j, 2 * pi));
    const double lo = fmax(c->theta_j - 6.5 * c->lambda_j, -pi / 2);
    const double hi = fmin(c->theta_j + 6.5 * c->lambda_j, pi / 2);
    const double per = 2 * cos(c->theta_j) / (c->lambda_j * c->lambda_j);
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double theta = lo + (hi - lo) * (i + 0.5) / STEPS;
        const double d = (theta - c->theta_o) / 2, ci = cos(theta);
        const double h = sin((theta - c->theta_j) / 2) / c->lambda_j;
        struct dual_mean m;
        dual_tables_mean(t, d, channel, &m);
        sum += exp(-4 * h * h) * ci / pi *
               half_lobe(fmax(per * ci, 1e-9), phi) * m.A_b *
               gauss(theta + c->theta_o - m.delta_b, sqrt(2) * m.sigma_b) * ci /
               (cos(d) * cos(d));
    }
    return sum * (hi - lo) / STEPS;
}

void dual_double_best(const struct dual_tables *t, const struct exact_case *c,
                      const double sigma_f[3], int channel, double out[4])
{
    for (int mode = 0; mode < 3; mode++)
        out[mode] = global_best(t, c, sigma_f, mode, channel);
    out[3] = local_best(t, c, sigma_f[channel], channel);
}

// --- paper ------------------------------------------------------------------
static double mean_index(const struct exact_case *c)
{
    double aa = c->a * c->a;
    return 1 + (c->eta - 1) * (aa + 1 / aa - 1);
}

// Integral over phi of N_t times 1, |phi|/pi, or 1/pi within a half circle.
enum weight { ALL, AHEAD, HALF };

static double around(const struct exact_case *c, int mode, double cos_d,
                     enum weight weight, double centre)
{
    enum { STEPS = 720 };
    double n[STEPS], sum = 0, span = weight == HALF ? pi : 2 * pi;
    const double at[2] = {cos_d, mean_index(c)};
    for (int i = 0; i < STEPS; i++)
        n[i] = centre + span * ((i + 0.5) / STEPS - 0.5);
    xu_double_azimuth(c, mode, at, n, STEPS);
    for (int i = 0; i < STEPS; i++) {
        double phi = centre + span * ((i + 0.5) / STEPS - 0.5);
        double w = weight == AHEAD  ? fabs(remainder(phi, 2 * pi)) / pi
                   : weight == HALF ? 1 / pi
                                    : 1;
        sum += n[i] * w * span / STEPS;
    }
    return sum;
}

void dual_double_paper_half(const struct exact_case *c, double theta_d,
                            double phi, double out[3])
{
    for (int t = 0; t < 3; t++)
        out[t] = around(c, t, cos(theta_d), HALF, phi);
}

static double along(const void *self, double theta_o)
{
    double theta = *(const double *)self, cd = cos((theta_o - theta) / 2);
    return fmax(cos(theta_o), 0) * cos(theta) / fmax(cd * cd, 1e-8);
}

void dual_double_paper_mean(const struct exact_case *c, double theta,
                            struct exact_dual_mean *out)
{
    struct exact_dual_mean m = {0};
    double f2 = 0, b2 = 0;
    for (int t = 0; t < 3; t++) {
        double l = 2 * sqrt(2) * c->beta[t], beta2 = c->beta[t] * c->beta[t];
        const double lobe[2] = {2 * c->alpha[t] - theta, l};
        double part = fmax(xu_double_linear(lobe, 4, false, along, &theta), 0) /
                      (sqrt(pi) * l);
        double f = part * around(c, t, cos(theta), AHEAD, 0);
        double b = part * around(c, t, cos(theta), ALL, 0) - f;
        m.a_f += f;
        m.a_b += b;
        m.alpha_f += f * c->alpha[t];
        m.alpha_b += b * c->alpha[t];
        f2 += f * beta2;
        b2 += b * beta2;
    }
    m.alpha_f /= m.a_f;
    m.alpha_b /= m.a_b;
    m.beta2_f = f2 / m.a_f;
    m.beta2_b = b2 / m.a_b;
    double x = m.a_f * m.a_f, y = 1 - x, ab = m.a_b;
    m.A_b = ab * x / y + ab * ab * ab * x / (y * y * y);
    m.delta_b = 2 * (m.alpha_b * (1 + 2 * ab * ab / (y * y)) +
                     m.alpha_f * (2 * y * y + 4 * x * ab * ab) / (y * y * y));
    m.sigma_b = 2 * (1 + 0.7 * x) *
                (ab * sqrt(2 * m.beta2_f + m.beta2_b) +
                 ab * ab * ab * sqrt(2 * m.beta2_f + 3 * m.beta2_b)) /
                (ab + ab * ab * ab);
    *out = m;
}

struct outer {
    const struct exact_case *c;
    int mode; // 3: S_back
};

static double outer_at(const void *self, double theta_i)
{
    const struct outer *o = self;
    const struct exact_case *c = o->c;
    double d = (c->theta_o - theta_i) / 2, ci = cos(theta_i), cd = cos(d);
    struct exact_dual_mean m;
    if (ci < 1e-9)
        return 0;
    if (o->mode == 3)
        dual_double_paper_mean(c, -d, &m);
    return ci * ci / (cd * cd) *
           (o->mode == 3 ? m.A_b
                         : around(c, o->mode, cd, HALF, c->phi_o - c->phi_j));
}

// Integral of the product of two normalised Gaussians and f.
static double product(const struct outer *o, double centre, double width,
                      double sigma_f)
{
    double w2 = width * width, s2 = sigma_f * sigma_f;
    double apart = centre - o->c->theta_j;
    const double lobe[2] = {o->c->theta_j + apart * s2 / (w2 + s2),
                            sqrt(w2 * s2 / (w2 + s2))};
    return gauss(apart, sqrt(w2 + s2)) / (sqrt(pi) * lobe[1]) *
           xu_double_linear(lobe, 4, false, outer_at, o);
}

void dual_double_paper(const struct exact_case *c, double sigma_f,
                       double out[4])
{
    enum { STEPS = 32 }; // of eq 31
    struct outer o = {c, 0};
    double delta = 0, sigma = 0, over = 1 / cos(c->theta_j);
    for (; o.mode < 3; o.mode++)
        out[o.mode] = over * product(&o, 2 * c->alpha[o.mode] - c->theta_o,
                                     2 * sqrt(2) * c->beta[o.mode], sigma_f);
    double mid = (c->theta_j - c->theta_o) / 2;
    double lo = fmax(mid - sigma_f / 2, -pi / 2);
    double hi = fmin(mid + sigma_f / 2, pi / 2);
    for (int i = 0; i < STEPS; i++) {
        struct exact_dual_mean m;
        dual_double_paper_mean(c, lo + (hi - lo) * (i + 0.5) / STEPS, &m);
        delta += m.delta_b / STEPS;
        sigma += m.sigma_b / STEPS;
    }
    double away = fabs(remainder(c->phi_o - c->phi_j, 2 * pi));
    out[3] = over * (pi - away) / (pi * pi) *
             product(&o, delta - c->theta_o, sqrt(2) * sigma, sigma_f);
}
