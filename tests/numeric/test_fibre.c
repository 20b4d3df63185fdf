// Scattering as a function of two directions: against the integrals of exact.h,
// its table against direct evaluation, its sampler against its density.
#include "renderer/fibre.h"
#include "renderer/fibre_private.h"
#include "renderer/exact.h"
#include "tests/check.h"
#include "tests/numeric/checks.h"

#include <stdint.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static struct fibre_spec typical(void)
{
    const double rad = pi / 180;
    return (struct fibre_spec){
        .eta = 1.55,
        .sigma_a = {0.15, 0.25, 0.45},
        .a = 1,
        .alpha = {-7.5 * rad, 3.75 * rad, 11.25 * rad},
        .beta = {7.5 * rad, 3.75 * rad, 15 * rad},
        .w_c = 10 * rad,
        .delta_eta = 0.3,
        .k_g = 1,
        .delta_h_m = 0.5,
    };
}

static struct fibre_spec of_row(const double *x)
{
    struct fibre_spec s = typical();
    s.eta = x[0];
    s.sigma_a[0] = x[1];
    s.sigma_a[1] = 0;
    s.sigma_a[2] = 2 * x[1] + 0.1;
    for (int t = 0; t < FIBRE_MODES; t++) {
        s.alpha[t] = x[2 + t];
        s.beta[t] = x[5 + t];
    }
    s.w_c = x[8];
    s.a = x[9];
    return s;
}

// --- against integrals over lights
// ---------------------------------------------

// Int G_j S cos theta_i d omega_i by equal steps over theta and phi about the
// light, as far as G_j reaches.
static void light_integral(const struct fibre *f, const double *x,
                           double sum[FIBRE_MODES][3])
{
    enum { THETAS = 400, PHIS = 600 };
    const double lambda = x[10], tj = x[11], pj = x[12];
    const struct fibre_direction o = {x[13], x[14]};
    const double lo = fmax(-pi / 2, tj - 6 * lambda);
    const double hi = fmin(pi / 2, tj + 6 * lambda);
    memset(sum, 0, FIBRE_MODES * sizeof *sum);
    for (int a = 0; a < THETAS; a++) {
        const double ti = lo + (hi - lo) * (a + 0.5) / THETAS;
        const double g = sin((ti - tj) / 2) / lambda;
        const double k = 2 * cos(ti) * cos(tj) / (lambda * lambda);
        const double reach = fmin(pi, 6 * sqrt(2 / k));
        for (int b = 0; b < PHIS; b++) {
            const double off = reach * (2 * (b + 0.5) / PHIS - 1);
            const double h = sin(off / 2);
            const struct fibre_direction i = {ti, pj + off};
            double s[FIBRE_MODES][3];
            fibre_scatter(f, &o, &i, s);
            const double w = exp(-4 * g * g - 2 * k * h * h) * cos(ti) *
                             (hi - lo) / THETAS * 2 * reach / PHIS;
            for (int t = 0; t < FIBRE_MODES; t++)
                for (int c = 0; c < 3; c++)
                    sum[t][c] += w * s[t][c];
        }
    }
}

// Equal steps leave 1.2e-4 in R, whose N folds at phi = pi, and 6e-6 elsewhere
// (measured); four times that.  Values below 1e-12 lie beyond the cut at eight
// deviations.
static void against_values(void)
{
    check_case("lights integrated over S are the values found elsewhere");
    for (int r = 0; r < CHECKS_ROWS; r++) {
        const double *x = checks[r];
        const struct fibre_spec s = of_row(x);
        if (s.a != 1)
            continue; // below
        struct fibre *f = fibre_create(&s);
        double got[FIBRE_MODES][3], least = 0;
        light_integral(f, x, got);
        for (int t = 0; t < FIBRE_MODES; t++)
            least = fmax(least, x[CHECKS_EXACT + t]);
        for (int t = 0; t < FIBRE_MODES; t++)
            if (x[CHECKS_EXACT + t] > fmax(1e-4 * least, 1e-12))
                CHECK_NEAR(got[t][0] / x[CHECKS_EXACT + t], 1, 5e-4);
        fibre_destroy(f);
    }
}

int main(void)
{
    against_values();
    return check_end();
}
