// dual_double.h - dual scattering once more, in double precision and apart from
// shaders and tables: what the shader's single precision and the closed forms
// of scheme `paper` are compared with.
#ifndef TESTS_NUMERIC_DUAL_DOUBLE_H
#define TESTS_NUMERIC_DUAL_DOUBLE_H

#include "renderer/dual_tables.h"
#include "renderer/exact_dual.h"

// Scheme `best` of one channel: the same series (from t) and nodes, the plain
// sum instead of Hermite's for M^L.  out: M^G_R M^G_TT M^G_TRT M^L.
// sigma_f[3]: the nodes belong to the mean of all three.
void dual_double_best(const struct dual_tables *t, const struct exact_case *c,
                      const double sigma_f[3], int channel, double out[4]);

// M^L of the light itself: its own lobe instead of psi_f, by equal steps.
double dual_double_glow(const struct dual_tables *t, const struct exact_case *c,
                        int channel);

// Scheme `paper`, m = 4, nothing from the tables: every integral over phi by
// equal steps.  sigma_f of all channels.
void dual_double_paper(const struct exact_case *c, double sigma_f,
                       double out[4]);
void dual_double_paper_mean(const struct exact_case *c, double theta,
                            struct exact_dual_mean *out);
void dual_double_paper_half(const struct exact_case *c, double theta_d,
                            double phi, double out[3]);

#endif
