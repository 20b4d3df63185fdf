// lights.c - fills the shaders' light block.  The fit itself is sky.h's.
#include "renderer/lights.h"

#include <math.h>
#include <string.h>

#include "renderer/gl.h"

struct light_std140 {
    float place[4], radiance[4];
};
struct block_std140 {
    struct light_std140 light[SKY_LIGHTS_MAX];
    uint32_t count, pad[3];
};

void lights_init(struct lights *l)
{
    memset(l, 0, sizeof *l);
    gl.CreateBuffers(1, &l->block);
    gl.NamedBufferStorage(l->block, sizeof(struct block_std140), NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, l->block, -1, "lights");
}

void lights_finish(struct lights *l)
{
    gl.DeleteBuffers(1, &l->block);
    memset(l, 0, sizeof *l);
}

// Map direction -> world direction, row-major: Rz(yaw) Rx(pitch) Ry(roll).
static void rotation(const struct params *p, double m[9])
{
    const double rad = M_PI / 180;
    double cz = cos(p->light.yaw * rad), sz = sin(p->light.yaw * rad);
    double cx = cos(p->light.pitch * rad), sx = sin(p->light.pitch * rad);
    double cy = cos(p->light.roll * rad), sy = sin(p->light.roll * rad);
    const double xy[9] = {cy,      0,  sy,       // Rx(pitch) Ry(roll)
                          sx * sy, cx, -sx * cy, //
                          -cx * sy, sx, cx * cy};
    for (int c = 0; c < 3; c++) {
        m[c] = cz * xy[c] - sz * xy[3 + c];
        m[3 + c] = sz * xy[c] + cz * xy[3 + c];
        m[6 + c] = xy[6 + c];
    }
}

static double power_of(const struct sky_light *s)
{
    return (s->radiance[0] + s->radiance[1] + s->radiance[2]) / 3 *
           sky_lobe_omega(s->lambda);
}

// Lights come by falling energy: the tail is what may be dropped.
static int count_needed(const struct sky_fit *fit, double bound, double *share)
{
    double total = 0, tail = 0;
    for (int j = 0; j < fit->count; j++)
        total += power_of(&fit->light[j]);
    int n = fit->count;
    while (n > 1 && tail + power_of(&fit->light[n - 1]) <= bound * total)
        tail += power_of(&fit->light[--n]);
    *share = total > 0 ? tail / total : 0;
    return n;
}

void lights_update(struct lights *l, const struct sky_fit *fit,
                   const struct params *p)
{
    struct block_std140 block = {0};
    double m[9], gain = exp2(p->tint.exposure);
    rotation(p, m);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            l->to_map[3 * r + c] = (float)m[3 * c + r];
    l->fitted = fit->count;
    l->used = count_needed(fit, p->quality.light_bound, &l->dropped_share);
    for (int j = 0; j < l->used; j++) {
        const struct sky_light *s = &fit->light[j];
        struct light_std140 *out = &block.light[j];
        for (int r = 0; r < 3; r++) {
            double d = 0;
            for (int c = 0; c < 3; c++)
                d += m[3 * r + c] * s->direction[c];
            out->place[r] = (float)d;
            out->radiance[r] = (float)(s->radiance[r] * gain *
                                       (double)p->tint.colour[r]);
        }
        out->place[3] = (float)s->lambda;
        out->radiance[3] = (float)sky_lobe_omega(s->lambda);
    }
    block.count = (uint32_t)l->used;
    gl.NamedBufferSubData(l->block, 0, sizeof block, &block);
}
