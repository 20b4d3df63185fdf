// dual_paper.c - Schlick's Fresnel, the Taylor series of the attenuation, one
// lobe for TT and three or one for TRT: what the paper approximates is
// approximated here too, in double precision.
#include "renderer/dual_paper.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

struct slice {
    double c;    // cos theta_d
    double eta1; // eta'
    double f0;
};

static double schlick(const struct slice *s, double h)
{
    return s->f0 + (1 - s->f0) * pow(1 - s->c * sqrt(fmax(1 - h * h, 0)), 5);
}

static struct slice slice_at(double eta, double cos_d)
{
    double c = fmax(cos_d, 1e-4), f0 = (eta - 1) / (eta + 1);
    return (struct slice){c, sqrt(eta * eta - 1 + c * c) / c, f0 * f0};
}

// 2 Int_0^pi phi |cos^k(phi/2)| dphi, and 2 pi Int_0^pi of the power alone.
static void energy_r(const struct slice *s, struct dual_energy *out)
{
    static const double first[7] = {9.8696044011, 4.5663706144, 2.9348022005,
                                    2.1553581898, 1.7011016503, 1.4042865517,
                                    1.1953624948};
    const double zeroth[7] = {pi,         2,        pi / 2,     4. / 3,
                              3 * pi / 8, 16. / 15, 5 * pi / 16};
    double q = 1 - s->f0, c = s->c, ahead = 0, all = 0;
    const double coefficient[7] = {0,
                                   0.25,
                                   -1.25 * q * c,
                                   2.5 * q * c * c,
                                   -2.5 * q * c * c * c,
                                   1.25 * q * pow(c, 4),
                                   -0.25 * q * pow(c, 5)};
    for (int k = 0; k < 7; k++) {
        ahead += coefficient[k] * first[k] / pi;
        all += coefficient[k] * zeroth[k] * 2;
    }
    out->ahead[DUAL_R] = ahead;
    out->all[DUAL_R] = all;
}

// Int_0^pi phi exp(-(phi - mu)^2/l^2) dphi and the same without phi.
static void moments(double mu, double l, double *first, double *zeroth)
{
    double a = -mu / l, b = (pi - mu) / l;
    *zeroth = l * sqrt(pi) / 2 * (erf(b) - erf(a));
    *first = mu * *zeroth + l * l / 2 * (exp(-a * a) - exp(-b * b));
}

// Adds b exp(-(phi - mu)^2/l^2) of -pi <= phi <= pi.
static void add_lobe(double b, double mu, double l, double *ahead, double *all)
{
    double first, zeroth;
    if (!(b > 0))
        return;
    for (int sign = -1; sign <= 1; sign += 2) {
        moments(sign * mu, l, &first, &zeroth);
        *ahead += b * first / pi;
        *all += b * zeroth;
    }
}

// 1/2 Int (1-F)^2 F^r T^(1+r) dh by the series of eq 18 and 22.
static double energy_series(const struct slice *s, double sigma, int r)
{
    double st = sigma * (1 + r), e2 = s->eta1 * s->eta1, sum = 0;
    double a2 = st / e2, a4 = (st / 4 + st * st / 2) / (e2 * e2);
    enum { STEPS = 32 }; // h = sin g: equal steps of a periodic function
    for (int i = 0; i < STEPS; i++) {
        double g = pi / 2 * (i + 0.5) / STEPS, h2 = sin(g) * sin(g);
        double f = schlick(s, sin(g));
        sum += cos(g) * (1 - f) * (1 - f) * (r ? f : 1) *
               (1 + a2 * h2 + a4 * h2 * h2) * pi / 2 / STEPS;
    }
    return exp(-2 * st) * sum;
}

static void energy_tt(const struct slice *s, double sigma, double *ahead,
                      double *all)
{
    double f = schlick(s, 0), e = s->eta1;
    double b = e / (4 * (e - 1)) * (1 - f) * (1 - f) * exp(-2 * sigma);
    double l = energy_series(s, sigma, 0) / (sqrt(pi) * b), first, zeroth;
    if (!(b > 0))
        return;
    // Centred on pi: |phi| = pi - y, both sides of y.
    zeroth = l * sqrt(pi) * erf(pi / l);
    first = l * l * (1 - exp(-pi * pi / (l * l)));
    *ahead += b * (zeroth - first / pi);
    *all += b * zeroth;
}

static double n_trt(const struct slice *s, double sigma, double h)
{
    double f = schlick(s, h), e2 = s->eta1 * s->eta1;
    double slope = 4 / sqrt(e2 - h * h) - 2 / sqrt(fmax(1 - h * h, 1e-12));
    return 0.5 / fmax(fabs(slope), 2e-6) * (1 - f) * (1 - f) * f *
           exp(-4 * sigma * sqrt(1 - h * h / e2));
}

static void energy_trt(const struct slice *s, const struct dual_fibre *f,
                       double sigma, double *ahead, double *all)
{
    double whole = energy_series(s, sigma, 1), e = s->eta1;
    double peak = n_trt(s, sigma, 0), w = f->w_c;
    if (!(peak > 0))
        return;
    if (e < 2) {
        if (e >= sqrt(2))
            peak += 2 * n_trt(s, sigma, e * sqrt(1 - e * e / 4));
        double h = sqrt((4 - e * e) / 3);
        double at = fmax(fabs(4 * asin(h / e) - 2 * asin(h)), 1e-3);
        double away = 1 - exp(2 * (cos(at) - 1) / (w * w));
        double b2 = peak * away * away;
        double b1 = (whole - b2 * sqrt(pi) * at) / (2 * sqrt(pi) * w);
        add_lobe(b1, at, w, ahead, all);
        add_lobe(b2, 0, at, ahead, all);
        add_lobe(b1, -at, w, ahead, all);
        return;
    }
    double l = whole / (sqrt(pi) * peak);
    double t = fmin((e - 2) / f->delta_eta, 1);
    double blended = w + (l - w) * t * t * (3 - 2 * t);
    add_lobe(peak * l / blended, 0, blended, ahead, all);
}

void dual_paper_energy(const struct dual_fibre *f, double cos_d,
                       struct dual_energy *out)
{
    struct slice s = slice_at(f->eta, cos_d);
    double aa = f->a * f->a, eta = f->eta;
    double mean = 1 + (eta - 1) * (aa + 1 / aa - 1); // of eq 24
    struct slice turned = slice_at(mean, cos_d);
    memset(out, 0, sizeof *out);
    energy_r(&s, out);
    for (int k = 0; k < 3; k++) {
        double root = sqrt(eta * eta - 1 + s.c * s.c);
        double root_mean = sqrt(mean * mean - 1 + s.c * s.c);
        energy_tt(&s, f->sigma_a[k] * eta / root, &out->ahead[DUAL_TT + k],
                  &out->all[DUAL_TT + k]);
        energy_trt(&turned, f, f->sigma_a[k] * mean / root_mean,
                   &out->ahead[DUAL_TRT + k], &out->all[DUAL_TRT + k]);
    }
}

// Gaussian times the line through (x0, f0) and (x1, f1), over [x0, x1].
static double segment(double mu, double l, const double x[2], const double f[2])
{
    double t0 = (x[0] - mu) / l, t1 = (x[1] - mu) / l, d = x[1] - x[0];
    if (d < 1e-3 * l)
        return d * exp(-t0 * t0) * (f[0] + f[1]) / 2;
    double e = l * sqrt(pi) / 2 * (erf(t1) - erf(t0));
    double j = l * l / 2 * (exp(-t0 * t0) - exp(-t1 * t1));
    double rise = (j - (x[0] - mu) * e) / d;
    return (e - rise) * f[0] + rise * f[1];
}

double dual_paper_along(const struct dual_fibre *f, int mode, double theta)
{
    double l = 2 * sqrt(2) * f->beta[mode], mu = 2 * f->alpha[mode] - theta;
    double x[2] = {-pi / 2, 0}, v[2] = {0, 0}, sum = 0;
    for (int s = 1; s <= 4; s++) {
        x[1] = s == 4 ? pi / 2 : fmin(fmax(mu + (s - 2) * l, -pi / 2), pi / 2);
        double c = fmax(cos((x[1] - theta) / 2), 1e-4);
        v[1] = fmax(cos(x[1]), 0) * cos(theta) / (c * c);
        sum += segment(mu, l, x, v);
        x[0] = x[1];
        v[0] = v[1];
    }
    return fmax(sum, 0) / (sqrt(pi) * l);
}
