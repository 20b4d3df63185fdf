// sky_studio.c - the sky for a user who has none: a photographer's studio
// around hair that is seen from the front (-y).  A large warm key box at the
// left, a dimmer cool fill at the right, a narrow strip and a small box behind
// for the rim, a hair light above; walls that fall off to a dark floor.
#include "renderer/sky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/digest.h"
#include "renderer/sky_clean.h"

static const double pi = 3.14159265358979323846;

const char *const sky_builtin_names[] = {"studio", NULL};

struct box { // a lit rectangle with soft edges, facing the hair
    double azimuth, elevation; // of its centre: degrees from +x, from level
    double width, height;      // full angles, degrees
    double turn;               // of its upright about its centre, degrees
    double soft;               // share of the half size that fades
    double rgb[3];             // radiance in the middle
};

// The camera stands at azimuth -90, the rim lights opposite.
static const struct box boxes[] = {
    {-142, 30, 62, 46, -8, 0.35, {14, 12.4, 10.6}}, // key
    {-32, 8, 58, 70, 0, 0.60, {1.7, 2.0, 2.4}},     // fill
    {52, 26, 13, 74, 12, 0.30, {15, 16.6, 19.5}},   // rim strip, right
    {133, 34, 22, 30, -10, 0.35, {9.0, 9.5, 10.6}}, // rim, left
    {90, 74, 44, 30, 0, 0.45, {5.0, 4.9, 4.7}},     // hair light
};

static void unit(double azimuth, double elevation, double out[3])
{
    double a = azimuth * pi / 180, e = elevation * pi / 180;
    out[0] = cos(e) * cos(a);
    out[1] = cos(e) * sin(a);
    out[2] = sin(e);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double smooth(double from, double to, double x)
{
    double t = fmin(1, fmax(0, (x - from) / (to - from)));
    return t * t * (3 - 2 * t);
}

// 1 inside, 0 outside.
static double coverage(const struct box *b, const double d[3])
{
    double c[3], right[3], up[3], tr = b->turn * pi / 180;
    double a = b->azimuth * pi / 180;
    unit(b->azimuth, b->elevation, c);
    double depth = dot(c, d);
    if (depth <= 0.05)
        return 0;
    double r0[3] = {-sin(a), cos(a), 0}, u0[3];
    u0[0] = c[1] * r0[2] - c[2] * r0[1];
    u0[1] = c[2] * r0[0] - c[0] * r0[2];
    u0[2] = c[0] * r0[1] - c[1] * r0[0];
    for (int i = 0; i < 3; i++) {
        right[i] = cos(tr) * r0[i] + sin(tr) * u0[i];
        up[i] = cos(tr) * u0[i] - sin(tr) * r0[i];
    }
    double x = fabs(dot(right, d)) / depth / tan(b->width * pi / 360);
    double y = fabs(dot(up, d)) / depth / tan(b->height * pi / 360);
    double low = 1 - b->soft;
    // Cloth in front of a lamp: brighter in the middle.
    double glow = 1 - 0.25 * fmin(1, x * x + y * y);
    return glow * (1 - smooth(low, 1 + b->soft, x)) *
           (1 - smooth(low, 1 + b->soft, y));
}

static void radiance(const double d[3], double rgb[3])
{
    // Walls: dim and slightly blue above, a warm dark floor that returns a
    // little of the key; the backdrop behind the hair is darkest.
    double up = smooth(-0.25, 0.9, d[2]), floor = smooth(0.05, -0.8, d[2]);
    double back = smooth(0.2, 1, d[1]);
    static const double wall[3] = {0.030, 0.034, 0.040};
    static const double ceiling[3] = {0.050, 0.054, 0.062};
    static const double ground[3] = {0.046, 0.040, 0.034};
    for (int k = 0; k < 3; k++)
        rgb[k] = (wall[k] + (ceiling[k] - wall[k]) * up) * (1 - floor) *
                     (1 - 0.45 * back) +
                 ground[k] * floor;
    for (size_t i = 0; i < sizeof boxes / sizeof boxes[0]; i++) {
        double c = coverage(&boxes[i], d);
        for (int k = 0; k < 3; k++)
            rgb[k] += c * boxes[i].rgb[k];
    }
}

struct sky_map *sky_builtin(const char *name, struct error *err)
{
    if (strcmp(name, "studio") != 0) {
        error_set(err, "unknown", name,
                  "there is no built-in sky '%.40s'; "
                  "there is: studio",
                  name);
        return NULL;
    }
    struct sky_map *m = bytes_zalloc(1, sizeof *m);
    m->width = 512;
    m->height = 256;
    strncpy(m->name, "builtin:studio", sizeof m->name - 1);
    size_t count = 3 * (size_t)m->width * (size_t)m->height;
    m->rgb = bytes_alloc(count * sizeof *m->rgb);
    float *to = m->rgb;
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++, to += 3) {
            double d[3], rgb[3];
            unit(180 - 360 * (x + 0.5) / m->width,
                 90 - 180 * (y + 0.5) / m->height, d);
            radiance(d, rgb);
            for (int k = 0; k < 3; k++)
                to[k] = (float)rgb[k];
        }
    sky_clean_run(m->rgb, m->width, m->height, &m->cleaned);
    digest_sha256(
        (struct span){(unsigned char *)m->rgb, count * sizeof *m->rgb},
        m->sha256);
    return m;
}
