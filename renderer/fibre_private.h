// fibre_private.h - what is behind a struct fibre.  For fibre*.c only.
// Thread: any; immutable once made.
#ifndef RENDERER_FIBRE_PRIVATE_H
#define RENDERER_FIBRE_PRIVATE_H

#include "renderer/fibre.h"

struct fibre_section { // through the fibre at one theta_d
    const struct fibre_spec *spec;
    double eta; // of Fresnel
    double cos_d;
    double path, real; // eta' of the paths phi(h), and of absorption
    double sigma[3];   // sigma_a'
};
// eta: of Fresnel and absorption; path: of phi(h).
void fibre_section_at(const struct fibre_spec *s, double theta_d, double eta,
                      double path, struct fibre_section *out);
// phi(p, h) of h = sin gamma (Xu 2011, eq 8), p internal segments.
double fibre_section_turn(const struct fibre_section *s, int p, double gamma);
// A(p, h) of eq 10, per channel.
void fibre_section_carry(const struct fibre_section *s, int p, double gamma,
                         double a[3]);
// Index of the paths where phi_i + phi_o = twice (Marschner 2003, 5.2.3).
double fibre_section_index(const struct fibre_spec *s, double twice);

// N_t, not divided by cos^2 theta_d.
void fibre_exact_r(const struct fibre_section *s, double phi, double n[3]);
void fibre_exact_tt(const struct fibre_section *s, double phi, double n[3]);
void fibre_exact_trt(const struct fibre_section *s, double phi, double n[3]);
// The last for all phi = pi k / columns, k = 0 .. columns: row[3 * k + c].
void fibre_exact_row(const struct fibre_section *s, int columns, double *row);
void fibre_marschner(const struct fibre_spec *s, double theta_d, double phi,
                     double twice, double n[FIBRE_MODES][3]);

struct fibre {
    struct fibre_spec spec;
    // N_TRT / cos^2 theta_d over (theta_d, phi), both ends included, RGB;
    // NULL: it is evaluated as it is asked for.
    int rows, columns;
    float *trt;
    // Integral of N_t over phi / cos^2 theta_d, at theta_d = pi/2 k / ENERGIES
    double (*energy)[FIBRE_MODES][3];
    // What phi is drawn from: [mode][row][bin], |phi| in `bins` of [0, pi];
    // densities of |phi|, and their sums before each bin.
    int draw_rows, bins;
    double *density, *below;
    double (*albedo)[FIBRE_MODES][3]; // at theta = pi (k / ALBEDOS - 1/2)
};
enum { FIBRE_ENERGIES = 256, FIBRE_ALBEDOS = 128 };

void fibre_draw_make(struct fibre *f);

#endif
