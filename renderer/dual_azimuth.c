// dual_azimuth.c - sums over h = sin gamma, and the fit of N^G.
//
// With c_n the cosine coefficients of N_t(phi),
//   c_n = (2 - [n = 0])/pi Int_0^{pi/2} A cos gamma cos(n phi(gamma)) dgamma /
//   2,
// smoothing multiplies them by I_n/I_0, and a half circle of light leaves
//   N^G = c_0 + sum over odd n of 2/(pi n) sin(n pi/2) c_n cos(n Phi)
// (even n integrate to zero).  The coefficients fall with a further 1/n, which
// is why a few will do.  Over all theta_d and colours they lie close to a plane
// of a few dimensions, which the eigenvectors of their second moments span; the
// course over theta_d within it is a polynomial, fitted to the relative error.
#include "renderer/dual_azimuth.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "renderer/quadrature.h"

static const double pi = 3.14159265358979323846;

enum {
    GAMMAS = 64, // nodes of a sum over h
    LANES = 8,   // DUAL_CHANNELS, and one that holds nothing
    MOST_TERMS = 64,
    ODD = 16,
    SAMPLES = DUAL_SAMPLES,
    MOST_POWERS = 9,
    MOST = DUAL_HARMONICS_TRT
};

// Gauss-Legendre in gamma on [0, pi/2]: of no fibre, made once.
static struct {
    double gamma[GAMMAS], weight[GAMMAS], sine[GAMMAS], cosine[GAMMAS];
} rule;
static pthread_once_t rule_once = PTHREAD_ONCE_INIT;

static void make_rule(void)
{
    quadrature_legendre(GAMMAS, rule.gamma, rule.weight);
    for (int i = 0; i < GAMMAS; i++) {
        rule.gamma[i] = pi / 4 * (1 + rule.gamma[i]);
        rule.weight[i] *= pi / 4;
        rule.sine[i] = sin(rule.gamma[i]);
        rule.cosine[i] = cos(rule.gamma[i]);
    }
}

struct dual_section dual_azimuth_section(const struct dual_fibre *f)
{
    struct dual_section s = {.eta = f->eta, .a = f->a, .w_c = f->w_c};
    memcpy(s.sigma_a, f->sigma_a, sizeof s.sigma_a);
    return s;
}

bool dual_azimuth_same(const struct dual_section *a,
                       const struct dual_section *b)
{
    return a->eta == b->eta && a->a == b->a && a->w_c == b->w_c &&
           a->sigma_a[0] == b->sigma_a[0] && a->sigma_a[1] == b->sigma_a[1] &&
           a->sigma_a[2] == b->sigma_a[2];
}

void dual_azimuth_init(struct dual_azimuth *z, const struct dual_section *s)
{
    // Below 0.04 the smoothing changes nothing that the series resolves.
    double w = fmax(s->w_c, 0.04), kappa = 2 / (w * w), whole = 0, aa = s->a;
    int steps = (int)(10 * pi / w) + 8;
    aa *= aa;
    memset(z, 0, sizeof *z);
    pthread_once(&rule_once, make_rule);
    z->section = *s;
    z->eta_path = 1 + (s->eta - 1) * (aa + 1 / aa - 1); // mean of eq 24
    for (int i = 0; i < steps; i++) { // equal steps round a circle
        double x = pi * (i + 0.5) / steps, g = exp(kappa * (cos(x) - 1));
        double now = cos(x), before = now, twice = 2 * cos(2 * x);
        whole += g;
        for (int k = 0; k < ODD; k++) {
            z->smooth[k] += g * now;
            double next = twice * now - before;
            before = now;
            now = next;
        }
    }
    for (int k = 0; k < ODD; k++)
        z->smooth[k] /= whole;
}

double dual_azimuth_schlick(double eta, double cos_d)
{
    double f0 = (eta - 1) / (eta + 1), u = 1 - 0.65 * cos_d;
    f0 *= f0;
    return f0 + (1 - f0) * u * u * u * u * u;
}

// One ray: phi of the three modes and A cos gamma dgamma of all channels.
struct ray {
    double phi[3], part[DUAL_CHANNELS];
};

static struct ray trace(const struct dual_azimuth *z, double c, int i)
{
    const struct dual_section *f = &z->section;
    double eta2 = f->eta * f->eta, root = sqrt(eta2 - 1 + c * c);
    double h = rule.sine[i], x = c * rule.cosine[i];
    double q = sqrt(eta2 - 1 + x * x), s = 1 / (x + q), p = 1 / (eta2 * x + q);
    double fs = (x - q) * s, fp = (eta2 * x - q) * p;
    double fresnel = (fs * fs + fp * fp) / 2;
    // (1 - F) / c without the difference, which grazing light leaves nothing of
    double enter = 2 * rule.cosine[i] * q * (s * s + eta2 * p * p);
    double inside = c * h / root, path = z->eta_path;
    double bend = c * h / sqrt(path * path - 1 + c * c);
    double length = 2 * f->eta / root * sqrt(1 - inside * inside);
    double w = rule.weight[i] * rule.cosine[i];
    struct ray r;
    r.phi[0] = 2 * rule.gamma[i];
    r.phi[1] = pi - 2 * rule.gamma[i] + 2 * asin(inside);
    r.phi[2] = 2 * rule.gamma[i] - 4 * asin(bend);
    r.part[DUAL_R] = w * fresnel;
    for (int k = 0; k < 3; k++) {
        double t = exp(-f->sigma_a[k] * length);
        r.part[DUAL_TT + k] = w * enter * enter * t;
        r.part[DUAL_TRT + k] = w * enter * enter * fresnel * t * t;
    }
    return r;
}

// |phi|/pi smoothed: 1/2 - 4/pi^2 sum over odd n of I_n/I_0 cos(n phi)/n^2.
static double forward(const struct dual_azimuth *z, double phi)
{
    double now = cos(phi), before = now, twice = 2 * cos(2 * phi), sum = 0;
    for (int k = 0; k < ODD; k++) {
        double n = 2 * k + 1, next = twice * now - before;
        sum += z->smooth[k] * now / (n * n);
        before = now;
        now = next;
    }
    return fmin(fmax(0.5 - 4 / (pi * pi) * sum, 0), 1);
}

// A ray's channels side by side, cos(n phi) and its recurrence with each of
// them: compilers make vectors of that.
struct lanes {
    double part[LANES], now[LANES], before[LANES], twice[LANES];
};

static void spread(const struct ray *r, struct lanes *v)
{
    double c[3];
    for (int t = 0; t < 3; t++)
        c[t] = cos(r->phi[t]);
    for (int k = 0; k < LANES; k++) {
        const int mode = k < DUAL_TT ? 0 : k < DUAL_TRT ? 1 : 2;
        v->part[k] = k < DUAL_CHANNELS ? r->part[k] : 0;
        v->now[k] = 1;
        v->before[k] = c[mode];
        v->twice[k] = 2 * c[mode];
    }
}

void dual_azimuth_cosines(const struct dual_azimuth *z, double cos_d, int count,
                          double (*out)[DUAL_CHANNELS])
{
    double sum[MOST_TERMS][LANES];
    memset(sum, 0, (size_t)count * sizeof *sum);
    for (int i = 0; i < GAMMAS; i++) {
        const struct ray r = trace(z, cos_d, i);
        struct lanes v;
        spread(&r, &v);
        for (int n = 0; n < count; n++)
            for (int k = 0; k < LANES; k++) {
                double now = v.now[k], next = v.twice[k] * now - v.before[k];
                sum[n][k] += v.part[k] * now;
                v.before[k] = now;
                v.now[k] = next;
            }
    }
    for (int n = 0; n < count; n++)
        for (int k = 0; k < DUAL_CHANNELS; k++)
            out[n][k] = sum[n][k] * ((n ? 2 : 1) / (2 * pi));
}

void dual_azimuth_energy(const struct dual_azimuth *z, double cos_d,
                         struct dual_energy *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; i < GAMMAS; i++) {
        struct ray r = trace(z, cos_d, i);
        const double ahead[3] = {r.phi[0] / pi, r.phi[1] / pi,
                                 forward(z, r.phi[2])};
        for (int k = 0; k < DUAL_CHANNELS; k++) {
            int mode = k == DUAL_R ? 0 : k < DUAL_TRT ? 1 : 2;
            out->all[k] += r.part[k];
            out->ahead[k] += r.part[k] * ahead[mode];
        }
    }
}

// --- the fit ----------------------------------------------------------------
static struct dual_sample sample_at(const struct dual_azimuth *z, double x)
{
    // eta/eta' = (1 + x)/2
    double v = (1 + x) / (2 * z->section.eta),
           eta2 = z->section.eta * z->section.eta;
    double c = v * sqrt((eta2 - 1) / (1 - v * v));
    double trt = 1 / dual_azimuth_schlick(z->section.eta, c);
    struct dual_sample s = {.x = x};
    for (int i = 0; i < GAMMAS; i++) {
        struct ray r = trace(z, c, i);
        double now[3], before[3], twice[3];
        for (int t = 0; t < 3; t++) {
            now[t] = before[t] = cos(r.phi[t]);
            twice[t] = 2 * (2 * now[t] * now[t] - 1);
        }
        for (int k = 0; k < DUAL_CHANNELS; k++)
            s.e[k][0] += r.part[k];
        for (int n = 1; n < DUAL_HARMONICS_TRT; n++) {
            for (int k = 0; k < DUAL_CHANNELS; k++)
                s.e[k][n] += r.part[k] * now[k == DUAL_R    ? 0
                                             : k < DUAL_TRT ? 1
                                                            : 2];
            for (int t = 0; t < 3; t++) {
                double next = twice[t] * now[t] - before[t];
                before[t] = now[t];
                now[t] = next;
            }
        }
    }
    for (int k = 0; k < DUAL_CHANNELS; k++) {
        double scale = k < DUAL_TRT ? 1 / (2 * pi) : trt / (2 * pi);
        s.e[k][0] *= scale;
        for (int n = 1; n < DUAL_HARMONICS_TRT; n++) {
            double blur = k < DUAL_TRT ? 1 : z->smooth[n - 1];
            double window = 2 / (pi * (2 * n - 1)) * (n % 2 ? 1 : -1);
            s.e[k][n] *= 2 * scale * blur * window;
        }
    }
    return s;
}

// Chebyshev polynomials to powers of x, in place.
static void to_powers(double *c, int count)
{
    double t0[MOST_POWERS] = {1}, t1[MOST_POWERS] = {0, 1};
    double out[MOST_POWERS] = {c[0]};
    for (int k = 1; k < count; k++) {
        double t2[MOST_POWERS] = {0};
        for (int p = 0; p <= k; p++)
            out[p] += c[k] * t1[p];
        for (int p = 0; p < count; p++)
            t2[p] = (p > 0 ? 2 * t1[p - 1] : 0) - t0[p];
        memcpy(t0, t1, sizeof t0);
        memcpy(t1, t2, sizeof t1);
    }
    memcpy(c, out, (size_t)count * sizeof *c);
}

// One mode's part in the fit: its channels, its waves and what they become.
struct part {
    int channel, channels, harmonics, waves, powers;
    double *wave, *row; // [waves][harmonics], [channels][waves][powers]
};

static bool dark(const struct dual_sample *s, int channel)
{
    return s->e[channel][0] < 1e-100; // nothing comes through
}

// Eigenvectors of the symmetric a by Jacobi's rotations: column j of v.
static void rotate(double a[MOST][MOST], double v[MOST][MOST], int n, int i,
                   int j)
{
    double t = atan2(2 * a[i][j], a[j][j] - a[i][i]) / 2, c = cos(t),
           s = sin(t);
    for (int k = 0; k < n; k++) {
        double x = a[k][i], y = a[k][j];
        a[k][i] = c * x - s * y;
        a[k][j] = s * x + c * y;
    }
    for (int k = 0; k < n; k++) {
        double x = a[i][k], y = a[j][k];
        a[i][k] = c * x - s * y;
        a[j][k] = s * x + c * y;
    }
    for (int k = 0; k < n; k++) {
        double x = v[k][i], y = v[k][j];
        v[k][i] = c * x - s * y;
        v[k][j] = s * x + c * y;
    }
}

static void find_waves(const struct dual_sample *s, const struct part *p)
{
    double a[MOST][MOST] = {{0}}, v[MOST][MOST] = {{0}};
    int n = p->harmonics;
    for (int c = p->channel; c < p->channel + p->channels; c++)
        for (int i = 0; i < SAMPLES; i++)
            for (int k = 0; k < n && !dark(&s[i], c); k++)
                for (int l = 0; l < n; l++)
                    a[k][l] += s[i].e[c][k] / s[i].e[c][0] * s[i].e[c][l] /
                               s[i].e[c][0];
    for (int k = 0; k < n; k++)
        v[k][k] = 1;
    for (int sweep = 0; sweep < 8; sweep++)
        for (int i = 0; i < n; i++)
            for (int j = i + 1; j < n; j++)
                if (fabs(a[i][j]) > 1e-15 * (a[i][i] + a[j][j]))
                    rotate(a, v, n, i, j);
    for (int m = 0; m < p->waves; m++) { // largest first
        int best = 0;
        for (int k = 1; k < n; k++)
            if (a[k][k] > a[best][best])
                best = k;
        for (int k = 0; k < n; k++)
            p->wave[m * n + k] = v[k][best];
        a[best][best] = -1;
    }
}

// Least squares over x of what a channel has of each wave, weighted by its mean
// over Phi.
static void fit(const struct dual_sample *s, const struct part *part,
                int channel)
{
    double a[MOST_POWERS][MOST_POWERS] = {{0}};
    double b[MOST_POWERS][DUAL_WAVES_TRT] = {{0}};
    int powers = part->powers, n = part->harmonics;
    for (int i = 0; i < SAMPLES; i++) {
        const double *e = s[i].e[channel];
        double t[MOST_POWERS] = {1, s[i].x};
        if (dark(&s[i], channel))
            continue;
        for (int p = 2; p < powers; p++)
            t[p] = 2 * s[i].x * t[p - 1] - t[p - 2];
        for (int m = 0; m < part->waves; m++) {
            double has = 0;
            for (int k = 0; k < n; k++)
                has += part->wave[m * n + k] * (e[k] / e[0]);
            for (int p = 0; p < powers; p++)
                b[p][m] += t[p] / e[0] * has;
        }
        for (int p = 0; p < powers; p++)
            for (int q = 0; q < powers; q++)
                a[p][q] += t[p] / e[0] * t[q] / e[0];
    }
    for (int p = 0; p < powers; p++) // symmetric and positive: no pivoting
        for (int r = p + 1; r < powers && a[p][p] > 0; r++) {
            double factor = a[r][p] / a[p][p];
            for (int q = p; q < powers; q++)
                a[r][q] -= factor * a[p][q];
            for (int m = 0; m < part->waves; m++)
                b[r][m] -= factor * b[p][m];
        }
    for (int m = 0; m < part->waves; m++) {
        double *row =
            part->row + ((channel - part->channel) * part->waves + m) * powers;
        for (int p = powers - 1; p >= 0; p--) {
            double v = b[p][m];
            for (int q = p + 1; q < powers; q++)
                v -= a[p][q] * row[q];
            row[p] = a[p][p] > 0 ? v / a[p][p] : 0;
        }
        to_powers(row, powers);
    }
}

void dual_azimuth_sample(const struct dual_azimuth *z, int i,
                         struct dual_sample *out)
{
    *out = sample_at(z, -cos(pi * (i + 0.5) / SAMPLES));
}

void dual_azimuth_fit(const struct dual_sample s[DUAL_SAMPLES], int mode,
                      struct dual_series *out)
{
    const struct part parts[3] = {{DUAL_R, 1, DUAL_HARMONICS, DUAL_WAVES_R,
                                   DUAL_POWERS, out->wave_r[0], out->r[0]},
                                  {DUAL_TT, 3, DUAL_HARMONICS, DUAL_WAVES_TT,
                                   DUAL_POWERS, out->wave_tt[0], out->tt[0][0]},
                                  {DUAL_TRT, 3, DUAL_HARMONICS_TRT,
                                   DUAL_WAVES_TRT, DUAL_POWERS_TRT,
                                   out->wave_trt[0], out->trt[0][0]}};
    const struct part *p = &parts[mode];
    find_waves(s, p);
    for (int c = 0; c < p->channels; c++)
        fit(s, p, p->channel + c);
}
