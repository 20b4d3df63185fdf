// xu_double.h - the scheme `paper` (Xu 2011, sections 4.1 and 4.2) once more,
// in double precision and as literally as the text allows: integrals by
// quadrature instead of tables, angles by asin.  What the shader is compared
// with.
#ifndef TESTS_NUMERIC_XU_DOUBLE_H
#define TESTS_NUMERIC_XU_DOUBLE_H

#include <stdbool.h>

#include "renderer/exact.h"

// fine: the node layout that converges as m grows (docs/METHODS.md).
void xu_double_modes(const struct exact_case *c, int m, bool fine,
                     double out[EXACT_MODES]);

// N_t as the paper has it: eq 13 for R, the lobes of eq 16 and 20 as plain
// Gaussians of the distance round the circle for TT and TRT, which has its own
// index.  phi[count] gives way to the values.
void xu_double_azimuth(const struct exact_case *c, int mode,
                       const double cos_d_eta_trt[2], double *phi, int count);

// Integral of exp(-(x - mu)^2/l^2) times f, which is taken as linear between
// the nodes of section 4.2.2 and zero at +-pi/2.
typedef double xu_double_function(const void *self, double x);
double xu_double_linear(const double mu_l[2], int m, bool fine,
                        xu_double_function *f, const void *self);

#endif
