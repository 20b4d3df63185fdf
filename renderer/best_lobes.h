// best_lobes.h - scheme `best`: TRT's azimuth made of lobes once an edit, so
// that a light against them is three products of circular Gaussians.
//
// The fibre's half width is cut into three panels of h.  A panel sends light
// into a range of phi; it becomes a circular Gaussian of the same energy and
// the same first Fourier moment (so that its mean direction and its spread are
// exact), convolved with the Gaussian of width w_c.  As functions of theta_d a
// panel's half angle, width and energy are smooth in
//   x = 2 eta / eta' - 1, eta / eta' = eta cos theta_d / sqrt(eta^2 - 1 +
//   cos^2 theta_d),
// and are kept as polynomials in it, fitted in double precision.
//
// Eccentric fibres: angle and width also depend on the index that the light's
// azimuth picks (Xu 2011, eq 24); they are a texture over (eta*, x).
#ifndef RENDERER_BEST_LOBES_H
#define RENDERER_BEST_LOBES_H

enum {
    BEST_LOBES_PANELS = 3,
    BEST_LOBES_TERMS = 10,   // of a polynomial in x
    BEST_LOBES_COLUMNS = 12, // eta* from its smallest to its largest
    BEST_LOBES_ROWS = 40,    // x from -1 to 1
    BEST_LOBES_LAYERS = 2,   // sin(phi/2); 1/kappa
    // As shaders/best.glsl declares them.
    BEST_LOBES_UNIT = 4,
    BEST_LOBES_BINDING = 7
};

struct best_fibre {
    double eta;
    double sigma_a[3]; // per fibre radius
    double a;          // eccentricity; 1 is circular
    double w_c;        // Xu width
};

struct best_lobes;

// Thread: any, one at a time; no GL is called.
struct best_lobes *best_lobes_create(void);
// Nothing is done when the fibre is the one of before.
void best_lobes_update(struct best_lobes *t, const struct best_fibre *f);
double best_lobes_ms(const struct best_lobes *t); // of the last update

// One panel, as the shader evaluates it (circular fibres): out = sin(phi/2),
// 1/kappa, and 1/2 Int A dh / cos^2 theta_d for red, green and blue.
void best_lobes_panel(const struct best_lobes *t, int panel, double cos_d,
                      double out[5]);
// The same from its definition.
void best_lobes_exact(const struct best_fibre *f, int panel, double cos_d,
                      double out[5]);

// Uploads what an update changed, binds texture unit and uniform block.
// Thread: render.
void best_lobes_bind(struct best_lobes *t);

// Thread: render, once it has been bound.  NULL is allowed.
void best_lobes_destroy(struct best_lobes *t);

#endif
