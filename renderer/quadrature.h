// quadrature.h - Gauss-Legendre rules that tables and references share.
// Thread: any (no state).
#ifndef RENDERER_QUADRATURE_H
#define RENDERER_QUADRATURE_H

// The rule of n points on [-1, 1]: x descending, w; double precision.
void quadrature_legendre(int n, double *x, double *w);

// The 8-point rule's positive half (Abramowitz & Stegun 1964, table 25.4).
static const double quadrature_x[4] = {
    0.1834346424956498049, 0.5255324099163289858, 0.7966664774136267396,
    0.9602898564975362317};
static const double quadrature_w[4] = {
    0.3626837833783619830, 0.3137066458778872874, 0.2223810344533744706,
    0.1012285362903762592};

// Node i of those eight on [a, b]; *w gets its weight.
static inline double quadrature_node(double a, double b, int i, double *w)
{
    *w = quadrature_w[i % 4] * (b - a) / 2;
    return (a + b) / 2 + (i < 4 ? b - a : a - b) / 2 * quadrature_x[i % 4];
}

#endif
