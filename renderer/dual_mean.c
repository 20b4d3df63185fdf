// dual_mean.c - means over modes, sums over paths.
#include "renderer/dual_mean.h"

#include <math.h>

// Zinke 2008, section 3.2: paths that turn back an odd number of times.
static void turn_back(struct dual_mean *m, enum dual_scheme scheme)
{
    double x = m->a_f * m->a_f, y = 1 - x, b2 = m->a_b * m->a_b;
    double r = b2 / (y * y), q = 1 + b2 - x;
    double pile = 2 * m->a_b / (q + sqrt(fmax(0, q * q - 4 * b2)));
    double nb = (1 + 3 * r) / (1 + r);
    double nf = 2 / y * (1 + r * (1 + 2 * x)) / (1 + r);
    if (scheme == DUAL_SCHEME_BEST) {
        // Layers without end: reflectance R = a_b + a_f^2 R / (1 - a_b R), of
        // which the first bounce is single scattering's.
        m->A_b = x * pile / (1 - m->a_b * pile);
        m->delta_b = 2 * (nb * m->alpha_b + nf * m->alpha_f);
        m->sigma_b = 2 * sqrt(nb * m->beta2_b + nf * m->beta2_f);
        return;
    }
    m->A_b = m->a_b * x / y * (1 + b2 / (y * y)); // eq 11, 13
    // Eq 16 with a plus; eq 17 without betas among the weights of its quotient.
    m->delta_b = 2 * (m->alpha_b * (1 + 2 * r) +
                      m->alpha_f * (2 * y * y + 4 * x * b2) / (y * y * y));
    m->sigma_b = 2 * (1 + 0.7 * x) *
                 (sqrt(2 * m->beta2_f + m->beta2_b) +
                  b2 * sqrt(2 * m->beta2_f + 3 * m->beta2_b)) /
                 (1 + b2);
}

void dual_mean_take(const struct dual_fibre *f, enum dual_scheme scheme,
                    const struct dual_energy *s, struct dual_mean out[3])
{
    const double tiny = 1e-30; // of a mode that nothing comes through
    for (int k = 0; k < 3; k++) {
        struct dual_mean m = {0};
        const int channel[3] = {DUAL_R, DUAL_TT + k, DUAL_TRT + k};
        for (int mode = 0; mode < 3; mode++) {
            double ahead = s->ahead[channel[mode]], alpha = f->alpha[mode];
            double b = fmax(s->all[channel[mode]] - ahead, 0) + tiny;
            double beta2 = f->beta[mode] * f->beta[mode];
            ahead += tiny;
            m.a_f += ahead;
            m.a_b += b;
            m.alpha_f += ahead * alpha;
            m.alpha_b += b * alpha;
            m.beta2_f += ahead * beta2;
            m.beta2_b += b * beta2;
        }
        m.alpha_f /= m.a_f;
        m.beta2_f /= m.a_f;
        m.alpha_b /= m.a_b;
        m.beta2_b /= m.a_b;
        // Tilted modes may weigh inclinations differently, and the paper's
        // lobes hold too much: never more light out than in.
        double more = (m.a_f + m.a_b) / (1 - 1e-4);
        if (more > 1) {
            m.a_f /= more;
            m.a_b /= more;
        }
        turn_back(&m, scheme);
        out[k] = m;
    }
}
