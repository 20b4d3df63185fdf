// dual_paper.h - one cross section and one fibre's mean attenuation in the way
// of Xu 2011, eq 33: the lobes of section 4.2 with plain Gaussians for their
// integrals, the inclination apart from the azimuth.
// Thread: any.
#ifndef RENDERER_DUAL_PAPER_H
#define RENDERER_DUAL_PAPER_H

#include "renderer/dual_azimuth.h"

// Azimuthal factors of eq 33, not divided by anything.
void dual_paper_energy(const struct dual_fibre *f, double cos_d,
                       struct dual_energy *out);

// Its factor along theta_o, by the linear quadrature of section 4.2.2, m = 4.
double dual_paper_along(const struct dual_fibre *f, int mode, double theta);

#endif
