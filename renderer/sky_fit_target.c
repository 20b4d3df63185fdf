// sky_fit_target.c - from the pixels of a map to the samples of a fit.
//
// Hair sees nothing of a sky above a spherical-harmonic degree of about 20, so
// the sky is blurred first by exp(50 (cos - 1)), an SRBF of width 0.2, and the
// lobes are fitted in that domain: an SRBF blurred by an SRBF is very nearly an
// SRBF, so the fit needs no convolution.  Samples are weighted by the inverse
// of their brightness, floored, so that dark parts are matched in proportion.
// The plain mode takes the map as it is with solid angle for weight.
#include "renderer/sky_fit_target.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/sky_clean.h"
#include "renderer/sky_fit_vector.h"

static const double pi = 3.14159265358979323846;

enum { FINE_W = 128, FINE_H = 64, COARSE_W = 64, COARSE_H = 32, STEPS = 32 };

static const double hair_blur = 50;      // kappa; lambda 0.2
static const double weight_floor = 0.05; // of the mean brightness
static const double sun_lambda = 0.02;   // no narrower lobe: a true sun has
                                         // 0.008, hair cannot tell
// Widest lobe of N: wide ones have no one transmittance, narrower ones leave
// ripples in an even sky; with 2 instead these reach half a percent of shading.
static const double widest = 2.2;     // over sqrt(N)
static const double plain_min = 0.05; // a sample's spacing on the fine grid
static const double plain_max = 4;    // all but constant

// Longitude falls from left to right, and the frame begins `turn` steps to the
// right of the map's left edge.
static void turn(int steps, const double in[3], double out[3])
{
    double a = 2 * pi * steps / STEPS, x = in[0], y = in[1];
    out[0] = cos(a) * x - sin(a) * y;
    out[1] = sin(a) * x + cos(a) * y;
    out[2] = in[2];
}

void sky_fit_target_to_map(const struct sky_fit_target *t, const double in[3],
                           double out[3])
{
    turn(-t->turn, in, out);
}

void sky_fit_target_from_map(const struct sky_fit_target *t, const double in[3],
                             double out[3])
{
    turn(t->turn, in, out);
}

double sky_fit_target_omega(double kappa)
{
    if (kappa < 1e-6)
        return 4 * pi * (1 - kappa);
    return 2 * pi * -expm1(-2 * kappa) / kappa;
}

// --- splat: energy onto the fine grid --------------------------------------

struct fine {
    double energy[3][FINE_W * FINE_H];
};

static void add(struct fine *f, int x, int y, double w, const double e[3])
{
    // Beyond a pole lies the row itself, half a turn away: what falls between
    // the rows next to the pole is shared by both sides of it, so that a sun
    // near the pole stays there.
    if (y < 0 || y >= FINE_H) {
        y = y < 0 ? -1 - y : 2 * FINE_H - 1 - y;
        x += FINE_W / 2;
    }
    x = (x + 2 * FINE_W) % FINE_W;
    for (int k = 0; k < 3; k++)
        f->energy[k][y * FINE_W + x] += w * e[k];
}

// Bilinear in position, so the centre of energy stays where it was; an area
// average would move a sun by up to a degree.
static void splat(struct fine *f, double u, double v, const double e[3])
{
    double px = u * FINE_W - 0.5, py = v * FINE_H - 0.5;
    int x = (int)floor(px), y = (int)floor(py);
    double fx = px - x, fy = py - y;
    add(f, x, y, (1 - fx) * (1 - fy), e);
    add(f, x + 1, y, fx * (1 - fy), e);
    add(f, x, y + 1, (1 - fx) * fy, e);
    add(f, x + 1, y + 1, fx * fy, e);
}

// Pixels coarser than the grid are cut, so that they leave no gaps.
static int pieces(int size, int grid)
{
    return size >= grid ? 1 : (grid + size - 1) / size;
}

// One row, from column `first` on.
static void splat_row(struct fine *f, const struct sky_map *m, int y, int first,
                      double map_energy[3])
{
    int nx = pieces(m->width, FINE_W), ny = pieces(m->height, FINE_H);
    const float *row = m->rgb + 3 * (size_t)y * (size_t)m->width;
    for (int sy = 0; sy < ny; sy++) {
        double q =
            sky_clean_solid_angle(y * ny + sy, m->width * nx, m->height * ny);
        double v = (y + (sy + 0.5) / ny) / m->height;
        for (int x = 0; x < m->width; x++) {
            const float *p = row + 3 * ((x + first) % m->width);
            double e[3] = {q * (double)p[0], q * (double)p[1],
                           q * (double)p[2]};
            for (int sx = 0; sx < nx; sx++)
                splat(f, (x + (sx + 0.5) / nx) / m->width, v, e);
            for (int k = 0; k < 3; k++)
                map_energy[k] += nx * e[k];
        }
    }
}

// Where the light comes from, in longitude, to 1/32 turn from the left edge; 0
// when it comes from nowhere in particular.  A map that is rolled by such steps
// is fitted in the same frame as the unrolled one, so it gives the same lights,
// turned: without that, rounding alone would lead the fit elsewhere.
static int heading(const struct sky_map *m)
{
    if (m->width % STEPS != 0)
        return 0;
    double c = 0, s = 0, total = 0;
    for (int x = 0; x < m->width; x++) {
        double e = 0, u = 2 * pi * (x + 0.5) / m->width;
        for (int y = 0; y < m->height; y++) {
            const float *p =
                m->rgb + 3 * ((size_t)y * (size_t)m->width + (size_t)x);
            e += sin(pi * (y + 0.5) / m->height) *
                 ((double)p[0] + (double)p[1] + (double)p[2]);
        }
        c += e * cos(u);
        s += e * sin(u);
        total += e;
    }
    if (!(hypot(c, s) > 1e-9 * total))
        return 0;
    int step = (int)floor(atan2(s, c) * STEPS / (2 * pi));
    return (step + STEPS) % STEPS;
}

// --- the grid --------------------------------------------------------------

static void make_grid(struct sky_fit_target *t, int width, int height)
{
    t->width = width;
    t->height = height;
    t->count = (size_t)width * (size_t)height;
    for (int k = 0; k < 3; k++) {
        t->direction[k] = bytes_alloc(t->count * sizeof(double));
        t->value[k] = bytes_zalloc(t->count, sizeof(double));
    }
    t->root = bytes_alloc(t->count * sizeof(double));
    size_t i = 0;
    for (int y = 0; y < height; y++) {
        double theta = pi * (y + 0.5) / height;
        for (int x = 0; x < width; x++, i++) {
            double phi = pi - 2 * pi * (x + 0.5) / width;
            t->direction[0][i] = sin(theta) * cos(phi);
            t->direction[1][i] = sin(theta) * sin(phi);
            t->direction[2][i] = cos(theta);
        }
    }
}

// T_i = sum_s e^{kappa (w_i . w_s - 1)} q_s L_s / Omega(kappa).  For a pair of
// rows the kernel depends on the difference in longitude alone: 128 values.
static void blur_rows(struct sky_fit_target *t, const struct fine *f, int yi,
                      int ys)
{
    double a = pi * (yi + 0.5) / COARSE_H, b = pi * (ys + 0.5) / FINE_H;
    double kernel[2 * FINE_W], norm = 1 / sky_fit_target_omega(t->blur);
    if (t->blur * (cos(a - b) - 1) < -40)
        return;
    for (int d = 0; d < 2 * FINE_W; d++) { // coarse x lies at fine 2 x + 0.5
        double phi = 2 * pi * (d - FINE_W - 0.5) / FINE_W;
        kernel[d] =
            norm *
            exp(t->blur * (cos(a) * cos(b) + sin(a) * sin(b) * cos(phi) - 1));
    }
    for (int k = 0; k < 3; k++) {
        const double *e = f->energy[k] + ys * FINE_W;
        double *to = t->value[k] + yi * COARSE_W;
        for (int x = 0; x < COARSE_W; x++) {
            const double *at = kernel + FINE_W - 2 * x;
            to[x] += sky_fit_vector_dot_dd(at, e, FINE_W);
        }
    }
}

static void make_hair(struct sky_fit_target *t, const struct fine *f,
                      int lights)
{
    t->blur = hair_blur;
    double blur_lambda = sqrt(2 / t->blur);
    t->lambda_min = hypot(sun_lambda, blur_lambda);
    t->lambda_max = hypot(widest / sqrt(lights), blur_lambda);
    make_grid(t, COARSE_W, COARSE_H);
    for (int yi = 0; yi < COARSE_H; yi++)
        for (int ys = 0; ys < FINE_H; ys++)
            blur_rows(t, f, yi, ys);
}

static void make_plain(struct sky_fit_target *t, const struct fine *f)
{
    t->lambda_min = plain_min;
    t->lambda_max = plain_max;
    make_grid(t, FINE_W, FINE_H);
    for (int k = 0; k < 3; k++)
        for (size_t i = 0; i < t->count; i++)
            t->value[k][i] =
                f->energy[k][i] /
                sky_clean_solid_angle((int)i / FINE_W, FINE_W, FINE_H);
}

// v_i, renormalised to the sum of solid angles, and with it the values.
static void weigh(struct sky_fit_target *t)
{
    double mean = 0, sum = 0, total = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < t->count; i++) {
            double q =
                sky_clean_solid_angle((int)i / t->width, t->width, t->height);
            double bright =
                (t->value[0][i] + t->value[1][i] + t->value[2][i]) / 3;
            if (pass == 0) {
                mean += q * bright / (4 * pi);
                continue;
            }
            t->root[i] = t->blur > 0 ? q / (bright / mean + weight_floor) : q;
            sum += t->root[i];
            total += q;
        }
    for (size_t i = 0; i < t->count; i++) {
        t->root[i] = sqrt(t->root[i] * total / sum);
        for (int k = 0; k < 3; k++) {
            t->value[k][i] *= t->root[i];
            t->norm2 += t->value[k][i] * t->value[k][i];
        }
    }
}

void sky_fit_target_init(struct sky_fit_target *t, const struct sky_map *map,
                         int lights, enum sky_fit_mode mode)
{
    *t = (struct sky_fit_target){.mode = mode};
    struct fine *f = bytes_alloc(sizeof *f);
    memset(f, 0, sizeof *f);
    t->turn = heading(map);
    for (int y = 0; y < map->height; y++)
        splat_row(f, map, y, t->turn * (map->width / STEPS), t->map_energy);
    if (mode == SKY_FIT_HAIR)
        make_hair(t, f, lights);
    else
        make_plain(t, f);
    free(f);
    t->black = !(t->map_energy[0] + t->map_energy[1] + t->map_energy[2] > 0);
    if (!t->black)
        weigh(t);
}

void sky_fit_target_finish(struct sky_fit_target *t)
{
    for (int k = 0; k < 3; k++) {
        free(t->direction[k]);
        free(t->value[k]);
    }
    free(t->root);
    *t = (struct sky_fit_target){0};
}
