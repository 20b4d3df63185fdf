// xu_tables.h - the precomputed integrals of Xu 2011: C_k (eq 14), H_k^TT
// (eq 19) and H_k^TRT (eq 23).  None depends on a scattering parameter, so they
// are made once for a resolution.
//
// Stored, all as smooth functions of order one (docs/METHODS.md):
//   cosine: C_k(lambda', Phi) / C_0(lambda'), k = 1..6.  Columns: lambda' from
//     0.001 to 10, logarithmic; rows: Phi from 0 to pi (C_k is even).  Two
//     halves one above the other: (C_1, C_3, C_5, 0), then (C_2, C_4, C_6, 0).
//   tt, trt: (H_0, H_2, H_4, 0) / (1 - F(theta_d, 0))^2.  Columns: eta from 1
//     to 10, logarithmic; rows: theta_d from 0 to pi/2 (H_k is even).
// The first and the last entry stand on the ends of their range.
#ifndef RENDERER_XU_TABLES_H
#define RENDERER_XU_TABLES_H

enum { XU_TABLES_TIMES_MAX = 8 };

// Texture units, as shaders/xu_azimuth.glsl declares them.
enum { XU_TABLES_COSINE, XU_TABLES_TT, XU_TABLES_TRT, XU_TABLES_UNITS };

struct xu_tables {
    int times;                         // multiple of the paper's 128 x 64
    int columns, rows;                 // 128 times, 64 times
    float *rgba[XU_TABLES_UNITS];      // [4 * columns * rows]; cosine: 2 rows
    unsigned texture[XU_TABLES_UNITS]; // 0 until bound for the first time
};

// times: 1 .. XU_TABLES_TIMES_MAX; about 10 ms * times^2.
// Thread: any.
struct xu_tables *xu_tables_create(int times);

// Uploads at the first call, then binds the three units.
// Thread: render.
void xu_tables_bind(struct xu_tables *t);

// Thread: render, once it has been bound.  NULL is allowed.
void xu_tables_destroy(struct xu_tables *t);

#endif
