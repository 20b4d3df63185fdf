// camera.c - view and projection as one matrix.
#include "renderer/camera.h"

#include <math.h>
#include <string.h>

static void cross(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float normalise(float v[3])
{
    float n = sqrtf(dot(v, v));
    if (n > 0)
        for (int i = 0; i < 3; i++)
            v[i] /= n;
    return n;
}

// Far enough that the box, seen from -y, fills at most 94 % of both sides.
static float distance_for(const struct params *p, const float half[3],
                          float tan_half)
{
    float aspect = (float)p->image.width / (float)p->image.height;
    float tall = half[2] / tan_half, wide = half[0] / (tan_half * aspect);
    return fmaxf(tall, wide) / 0.94f + half[1];
}

// right, up, forward; falls back to another up where it lies along the view.
static void axes(struct camera *c, const float up[3])
{
    for (int i = 0; i < 3; i++)
        c->forward[i] = c->target[i] - c->eye[i];
    if (!(normalise(c->forward) > 0))
        memcpy(c->forward, (float[3]){0, 1, 0}, sizeof c->forward);
    cross(c->forward, up, c->right);
    if (!(normalise(c->right) > 1e-4f)) {
        const float other[3] = {0, fabsf(c->forward[1]) < 0.9f,
                                fabsf(c->forward[1]) >= 0.9f};
        cross(c->forward, other, c->right);
        normalise(c->right);
    }
    cross(c->right, c->forward, c->up);
}

static void matrix(struct camera *c, float aspect)
{
    const float sx = 1 / (c->tan_half * aspect), sy = 1 / c->tan_half;
    for (int i = 0; i < 3; i++) {
        c->view_proj[4 * i + 0] = sx * c->right[i];
        c->view_proj[4 * i + 1] = sy * c->up[i];
        c->view_proj[4 * i + 2] = 0; // clip z = near, clip w = depth
        c->view_proj[4 * i + 3] = c->forward[i];
    }
    c->view_proj[12] = -sx * dot(c->right, c->eye);
    c->view_proj[13] = -sy * dot(c->up, c->eye);
    c->view_proj[14] = c->near;
    c->view_proj[15] = -dot(c->forward, c->eye);
}

void camera_resolve(const struct params *p, const float box_min[3],
                    const float box_max[3], struct camera *c)
{
    float half[3], up[3] = {0, 0, 1}, diagonal = 0;
    c->tan_half = tanf(p->camera.fov * (float)M_PI / 360);
    for (int i = 0; i < 3; i++) {
        half[i] = fmaxf(0.5f * (box_max[i] - box_min[i]), 1e-6f);
        diagonal += half[i] * half[i];
        c->target[i] = isnan(p->camera.target[0])
                           ? 0.5f * (box_min[i] + box_max[i])
                           : p->camera.target[i];
    }
    memcpy(c->eye, p->camera.eye, sizeof c->eye);
    if (isnan(c->eye[0])) {
        memcpy(c->eye, c->target, sizeof c->eye);
        c->eye[1] -= distance_for(p, half, c->tan_half);
    }
    if (!isnan(p->camera.up[0]))
        memcpy(up, p->camera.up, sizeof up);
    normalise(up);
    axes(c, up);
    c->near = 1e-3f * 2 * sqrtf(diagonal);
    matrix(c, (float)p->image.width / (float)p->image.height);
}
