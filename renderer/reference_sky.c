// reference_sky.c - the sky as even texels, and directions drawn from it.
#include <math.h>
#include <string.h>

#include "renderer/reference_private.h"
#include "renderer/sky_fit_target.h"
#include "renderer/sky_clean.h"

static const double pi = 3.14159265358979323846;

// splitmix64's mixing (Steele, Lea and Flood 2014).
static uint64_t mix(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

// Mixed at every step, so that the streams of neighbouring numbers are not one
// stream at two places.
void reference_random_begin(struct reference_random *r, uint64_t seed,
                            uint64_t a, uint64_t b)
{
    r->state = mix(mix(mix(seed) ^ a) + b);
}

double reference_random_next(struct reference_random *r)
{
    const uint64_t x = mix(r->state);
    r->state += 0x9e3779b97f4a7c15u;
    return (double)(x >> 11) * 0x1p-53;
}

// The frame of the fit's texels -> the map's -> the world.
static void turn(struct reference_sky *s, const struct sky_fit_target *t,
                 const struct params *p)
{
    double map[9];
    lights_rotation(p, map);
    for (int c = 0; c < 3; c++) {
        double unit[3] = {c == 0, c == 1, c == 2}, in_map[3];
        sky_fit_target_to_map(t, unit, in_map);
        for (int r = 0; r < 3; r++)
            s->to_world[3 * r + c] = map[3 * r] * in_map[0] +
                                     map[3 * r + 1] * in_map[1] +
                                     map[3 * r + 2] * in_map[2];
    }
}

void reference_sky_make(struct reference_sky *s, const struct sky_map *map,
                        const struct params *p)
{
    struct sky_fit_target t;
    memset(s, 0, sizeof *s);
    sky_fit_target_init(&t, map, 1, SKY_FIT_PLAIN);
    turn(s, &t, p);
    const double gain = exp2((double)p->tint.exposure);
    double all = 0;
    for (int i = 0; i < REFERENCE_TEXELS; i++) {
        const int row = i / REFERENCE_WIDTH;
        const double q =
            sky_clean_solid_angle(row, REFERENCE_WIDTH, REFERENCE_HEIGHT);
        s->omega[row] = q;
        s->chance[i] = 0;
        for (int c = 0; c < 3; c++) {
            // value is root times radiance, root the solid angle's root
            const double l = t.black ? 0 : t.value[c][i] * t.root[i] / q;
            s->radiance[i][c] = l * gain * (double)p->tint.colour[c];
            s->energy[c] += s->radiance[i][c] * q;
            s->chance[i] += s->radiance[i][c] * q;
        }
        all += s->chance[i];
    }
    sky_fit_target_finish(&t);
    s->black = !(all > 0);
    double before = 0;
    for (int i = 0; i < REFERENCE_TEXELS; i++) {
        s->chance[i] = s->black ? 0 : s->chance[i] / all;
        s->before[i] = before;
        before += s->chance[i];
    }
    s->suns = lights_suns(p, s->sun);
}

// Longitude falls from left to right, from pi; cos of the row's edges is even
// in solid angle between them.
void reference_sky_direction(const struct reference_sky *s, int texel, double u,
                             double v, double out[3])
{
    const int x = texel % REFERENCE_WIDTH, y = texel / REFERENCE_WIDTH;
    const double top = cos(pi * y / REFERENCE_HEIGHT);
    const double z = top + v * (cos(pi * (y + 1) / REFERENCE_HEIGHT) - top);
    const double phi = pi - 2 * pi * (x + u) / REFERENCE_WIDTH;
    const double r = sqrt(fmax(0, 1 - z * z));
    const double d[3] = {r * cos(phi), r * sin(phi), z};
    for (int k = 0; k < 3; k++)
        out[k] = s->to_world[3 * k] * d[0] + s->to_world[3 * k + 1] * d[1] +
                 s->to_world[3 * k + 2] * d[2];
}

int reference_sky_texel(const struct reference_sky *s, const double d[3])
{
    double own[3];
    for (int k = 0; k < 3; k++)
        own[k] = s->to_world[k] * d[0] + s->to_world[3 + k] * d[1] +
                 s->to_world[6 + k] * d[2];
    const double u = 0.5 - atan2(own[1], own[0]) / (2 * pi);
    const double v = acos(fmin(fmax(own[2], -1), 1)) / pi;
    int x = (int)(u * REFERENCE_WIDTH), y = (int)(v * REFERENCE_HEIGHT);
    x = x < REFERENCE_WIDTH ? x : REFERENCE_WIDTH - 1;
    y = y < REFERENCE_HEIGHT ? y : REFERENCE_HEIGHT - 1;
    return y * REFERENCE_WIDTH + x;
}

int reference_sky_draw(const struct reference_sky *s, double u)
{
    int lo = 0, hi = REFERENCE_TEXELS;
    while (hi - lo > 1) {
        const int mid = (lo + hi) / 2;
        *(s->before[mid] <= u ? &lo : &hi) = mid;
    }
    while (lo > 0 && !(s->chance[lo] > 0)) // rounding at the end
        lo--;
    return lo;
}
