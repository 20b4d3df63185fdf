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

#endif
