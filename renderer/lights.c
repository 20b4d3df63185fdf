// lights.c - fills the shaders' light block.  The fit itself is sky.h's.
#include "renderer/lights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"

struct light_std140 {
    float place[4], radiance[4];
};
struct block_std140 {
    struct light_std140 light[LIGHTS_MAX];
    uint32_t count, pad[3];
};

static _Atomic unsigned numbers;

void lights_init(struct lights *l)
{
    memset(l, 0, sizeof *l);
    l->content = bytes_zalloc(1, sizeof(struct block_std140));
    l->block = gl_buffer(sizeof(struct block_std140), NULL, "lights");
}

void lights_finish(struct lights *l)
{
    gl.DeleteBuffers(1, &l->block);
    free(l->content);
    memset(l, 0, sizeof *l);
}

// Rz(yaw) Rx(pitch) Ry(roll).
void lights_rotation(const struct params *p, double m[9])
{
    const double rad = M_PI / 180;
    double cz = cos(p->light.yaw * rad), sz = sin(p->light.yaw * rad);
    double cx = cos(p->light.pitch * rad), sx = sin(p->light.pitch * rad);
    double cy = cos(p->light.roll * rad), sy = sin(p->light.roll * rad);
    // clang-format off
    const double xy[9] = {cy,       0,  sy, // Rx(pitch) Ry(roll)
                          sx * sy,  cx, -sx * cy,
                          -cx * sy, sx, cx * cy};
    // clang-format on
    for (int c = 0; c < 3; c++) {
        m[c] = cz * xy[c] - sz * xy[3 + c];
        m[3 + c] = sz * xy[c] + cz * xy[3 + c];
        m[6 + c] = xy[6 + c];
    }
}

struct sun { // the three groups have the same rows
    double strength, colour[3], azimuth, elevation;
};

// clang-format off
#define SUN(s)                                                                 \
    {(s).strength,                                                             \
     {(s).colour[0], (s).colour[1], (s).colour[2]},                            \
     (s).azimuth * M_PI / 180,                                                 \
     (s).elevation * M_PI / 180}
// clang-format on

// Those that shine, in order.
static int suns_of(const struct params *p, struct sun out[LIGHTS_SUNS])
{
    const struct sun all[LIGHTS_SUNS] = {SUN(p->sun1), SUN(p->sun2),
                                         SUN(p->sun3)};
    int n = 0;
    for (int i = 0; i < LIGHTS_SUNS; i++)
        if (all[i].strength > 0)
            out[n++] = all[i];
    return n;
}

static double power_of(const struct sky_light *s)
{
    return (s->radiance[0] + s->radiance[1] + s->radiance[2]) / 3 *
           sky_lobe_omega(s->lambda);
}

// 1 on average.
static double share_of(const struct sky_fit *fit, int j)
{
    double total = 0;
    for (int i = 0; i < fit->count; i++)
        total += power_of(&fit->light[i]);
    return total > 0 ? power_of(&fit->light[j]) * fit->count / total : 1;
}

// Lights come by falling energy: the tail is what may be dropped.
static int count_needed(const struct sky_fit *fit, double bound, int most,
                        double *share)
{
    double total = 0, tail = 0;
    for (int j = 0; j < fit->count; j++)
        total += power_of(&fit->light[j]);
    int n = fit->count;
    while (n > most ||
           (n > 1 && tail + power_of(&fit->light[n - 1]) <= bound * total))
        tail += power_of(&fit->light[--n]);
    *share = total > 0 ? tail / total : 0;
    return n;
}

static void turn(const double m[9], const double d[3], float out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = (float)(m[3 * r] * d[0] + m[3 * r + 1] * d[1] +
                         m[3 * r + 2] * d[2]);
}

bool lights_put(struct lights *l, const struct sky_fit *fit,
                const struct params *p)
{
    struct lights_place place[LIGHTS_MAX];
    struct sun sun[LIGHTS_SUNS];
    double m[9];
    memset(place, 0, sizeof place); // compared as bytes below
    lights_rotation(p, m);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            l->to_map[3 * r + c] = (float)m[3 * c + r];
    int suns = suns_of(p, sun);
    int sky = count_needed(fit, p->quality.light_bound, LIGHTS_MAX - suns,
                           &l->dropped_share);
    for (int j = 0; j < sky; j++) {
        turn(m, fit->light[j].direction, place[j].direction);
        place[j].lambda = (float)fit->light[j].lambda;
        const double share = share_of(fit, j);
        place[j].dim = share < 1.0 / 16 ? 2 : share < 1.0 / 4;
        place[j].share = (float)share;
    }
    for (int i = 0; i < suns; i++) {
        const double *e = &sun[i].elevation, *a = &sun[i].azimuth;
        place[sky + i] =
            (struct lights_place){{(float)(cos(*e) * sin(*a)),
                                   (float)(-cos(*e) * cos(*a)), (float)sin(*e)},
                                  (float)LIGHTS_SUN_LAMBDA,
                                  0,
                                  1};
    }
    bool changed = l->used != sky + suns || l->suns != suns ||
                   memcmp(place, l->place, sizeof place) != 0;
    memcpy(l->place, place, sizeof place);
    l->fitted = fit->count;
    l->used = sky + suns;
    l->suns = suns;
    return changed;
}

int lights_suns(const struct params *p, struct lights_sun out[LIGHTS_SUNS])
{
    struct sun sun[LIGHTS_SUNS];
    const int n = suns_of(p, sun);
    for (int i = 0; i < n; i++) {
        const double e = sun[i].elevation, a = sun[i].azimuth;
        const double d[3] = {cos(e) * sin(a), -cos(e) * cos(a), sin(e)};
        memcpy(out[i].direction, d, sizeof d);
        for (int c = 0; c < 3; c++)
            out[i].irradiance[c] = sun[i].strength * sun[i].colour[c];
    }
    return n;
}

void lights_tint(struct lights *l, const struct sky_fit *fit,
                 const struct params *p, bool apart)
{
    struct block_std140 block = {0};
    struct sun sun[LIGHTS_SUNS];
    double tint[3];
    const int sky = l->used - l->suns;
    suns_of(p, sun);
    for (int c = 0; c < 3; c++) {
        tint[c] = exp2(p->tint.exposure) * (double)p->tint.colour[c];
        l->tint[c] = apart ? (float)tint[c] : 1;
        tint[c] = apart ? 1 : tint[c];
    }
    for (int j = 0; j < l->used; j++) {
        struct light_std140 *out = &block.light[j];
        const double lambda = (double)l->place[j].lambda;
        const double omega = sky_lobe_omega(lambda);
        memcpy(out->place, l->place[j].direction, 12);
        out->place[3] = l->place[j].lambda;
        out->radiance[3] = (float)omega;
        for (int c = 0; c < 3; c++)
            out->radiance[c] =
                j < sky ? (float)(fit->light[j].radiance[c] * tint[c])
                        : (float)(sun[j - sky].strength / omega *
                                  sun[j - sky].colour[c]);
    }
    for (int j = 0; j < l->used; j++)
        memcpy(l->radiance[j], block.light[j].radiance, sizeof l->radiance[j]);
    block.count = (uint32_t)l->used;
    if (l->made > 0 && memcmp(&block, l->content, sizeof block) == 0)
        return;
    memcpy(l->content, &block, sizeof block);
    gl.NamedBufferSubData(l->block, 0, sizeof block, &block);
    l->made = ++numbers;
}
