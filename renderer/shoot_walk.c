// shoot_walk.c - one ray through the tree.  Single precision and four at a time
// where only something may be left out, double precision where it is decided.
#include "renderer/shoot_walk.h"

#include <math.h>
#include <string.h>

#if defined(__x86_64__) && defined(__has_attribute)
#if __has_attribute(target_clones) && !defined(GLINT_SANITIZED)
#define CLONED __attribute__((target_clones("avx2", "default")))
#endif
#endif
#ifndef CLONED
#define CLONED
#endif
// A clone is only as good as what is inside it.
#define INSIDE static inline __attribute__((always_inline))

struct gaze { // a ray in the forms that the tests want; scene units
    double origin[3], direction[3], across[2][3], reach;
    struct shoot_own own;
    double start; // distance from the origin to where the floats begin
    float o[3], inverse[3], a[2][3], end;
    int behind[3]; // 1 where the direction is negative: the high side is first
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Two directions across the ray; exact for a ray along an axis.
static void across_of(const double d[3], double a[2][3])
{
    int k = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(d[i]) < fabs(d[k]))
            k = i;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double n = sqrt(d[i] * d[i] + d[j] * d[j]);
    a[0][k] = 0;
    a[0][i] = -d[j] / n;
    a[0][j] = d[i] / n;
    for (int c = 0; c < 3; c++) {
        const int u = (c + 1) % 3, v = (c + 2) % 3;
        a[1][c] = d[u] * a[0][v] - d[v] * a[0][u];
    }
}

// Where the ray is inside the box of everything.
static bool clip(const struct shoot_tree *t, const struct gaze *g, double *from,
                 double *to)
{
    *from = 0;
    *to = g->reach;
    for (int k = 0; k < 3; k++) {
        const double low = (double)t->low[k] - g->origin[k];
        const double high = (double)t->high[k] - g->origin[k];
        if (g->direction[k] == 0) {
            if (low > 0 || high < 0)
                return false;
            continue;
        }
        const double a = low / g->direction[k], b = high / g->direction[k];
        *from = fmax(*from, fmin(a, b));
        *to = fmin(*to, fmax(a, b));
    }
    return *from <= *to; // false for what is not a number as well
}

static void set_end(struct gaze *g, double to)
{
    g->end =
        (float)((to - g->start) * (1 + SHOOT_BOX_MARGIN) + SHOOT_BOX_MARGIN);
}

static bool look(const struct shoot *s, const struct shoot_ray *ray,
                 struct shoot_own own, struct gaze *g)
{
    for (int k = 0; k < 3; k++) {
        g->origin[k] = ray->origin[k] * s->unit;
        g->direction[k] = ray->direction[k];
    }
    g->reach = ray->reach * s->unit;
    g->own = own;
    double to;
    if (!clip(&s->tree, g, &g->start, &to))
        return false;
    across_of(g->direction, g->across);
    for (int k = 0; k < 3; k++) {
        g->o[k] = (float)(g->origin[k] + g->start * g->direction[k]);
        float d = (float)g->direction[k];
        g->behind[k] = d < 0;
        // never 0 times infinity
        g->inverse[k] = 1 / (fabsf(d) > 1e-20f ? d : d < 0 ? -1e-20f : 1e-20f);
        for (int i = 0; i < 2; i++)
            g->a[i][k] = (float)g->across[i][k];
    }
    set_end(g, to);
    return true;
}

// --- four at a time ----------------------------------------------------------

INSIDE shoot_f4 smaller(shoot_f4 a, shoot_f4 b)
{
    shoot_i4 m = a < b;
    return (shoot_f4)(((shoot_i4)a & m) | ((shoot_i4)b & ~m));
}

INSIDE shoot_f4 larger(shoot_f4 a, shoot_f4 b)
{
    shoot_i4 m = a > b;
    return (shoot_f4)(((shoot_i4)a & m) | ((shoot_i4)b & ~m));
}

INSIDE unsigned bits(shoot_i4 m)
{
#ifdef __SSE__
    return (unsigned)__builtin_ia32_movmskps((shoot_f4)m);
#else
    return (m[0] & 1u) | (m[1] & 2u) | (m[2] & 4u) | (m[3] & 8u);
#endif
}

// Children whose box the ray meets, and where it enters them.
INSIDE unsigned test_node(const struct shoot_node *n, const struct gaze *g,
                          shoot_f4 *near)
{
    shoot_f4 from = {0, 0, 0, 0}, to = {g->end, g->end, g->end, g->end};
    for (int k = 0; k < 3; k++) {
        from =
            larger((n->side[g->behind[k]][k] - g->o[k]) * g->inverse[k], from);
        to = smaller((n->side[1 - g->behind[k]][k] - g->o[k]) * g->inverse[k],
                     to);
    }
    *near = from;
    // both distances are right to 3 x 2^-24 of themselves
    return bits(from <= to * (1 + 0x1p-21f));
}

// Segments nearer to the ray than their radius: all that are, and few others.
INSIDE unsigned test_leaf(const struct shoot_leaf *l, const struct gaze *g)
{
    shoot_f4 p[2] = {{0}}, e[2] = {{0}};
    for (int k = 0; k < 3; k++) {
        const shoot_f4 to_a = l->a[k] - g->o[k], edge = l->b[k] - l->a[k];
        for (int i = 0; i < 2; i++) {
            p[i] += to_a * g->a[i][k];
            e[i] += edge * g->a[i][k];
        }
    }
    const shoot_f4 length2 = e[0] * e[0] + e[1] * e[1] + 1e-30f;
    shoot_f4 u = -(p[0] * e[0] + p[1] * e[1]) / length2;
    u = larger(smaller(u, (shoot_f4){1, 1, 1, 1}), (shoot_f4){0});
    const shoot_f4 x = p[0] + u * e[0], y = p[1] + u * e[1];
    return bits(x * x + y * y <= l->reach2);
}

// --- one segment, decided ----------------------------------------------------

struct meeting {
    double distance, along; // scene units
};

INSIDE bool meets(const struct shoot_leaf *l, int lane, const struct gaze *g,
                  struct meeting *m)
{
    double q[3], e[3];
    for (int k = 0; k < 3; k++) {
        q[k] = (double)l->a[k][lane] - g->origin[k];
        e[k] = (double)l->b[k][lane] - (double)l->a[k][lane];
    }
    const double qx = dot(q, g->across[0]), qy = dot(q, g->across[1]);
    const double ex = dot(e, g->across[0]), ey = dot(e, g->across[1]);
    const double length2 = ex * ex + ey * ey;
    if (!(length2 > 1e-20 * dot(e, e)))
        return false; // along the ray
    m->along = -(qx * ex + qy * ey) / length2;
    const double part = m->along * SHOOT_PARTS;
    if (!(part >= l->from[lane] && part < l->to[lane]))
        return false; // beyond its ends, or another leaf's
    const double a = (double)l->radius_a[lane], b = (double)l->radius_b[lane];
    const double radius = a + m->along * (b - a);
    const double area = qx * ey - qy * ex;
    if (area * area > radius * radius * length2)
        return false;
    m->distance = dot(q, g->direction) + m->along * dot(e, g->direction);
    if (!(m->distance > 0 && m->distance < g->reach))
        return false;
    const uint32_t segment = l->segment[lane];
    return !(segment >= g->own.begin && segment < g->own.end &&
             m->distance < 16 * radius);
}

// --- what a meeting means ----------------------------------------------------

static void pass(const struct shoot *s, uint32_t segment, double along,
                 struct shoot_walk *w)
{
    const double a = (double)s->opacity[segment];
    const double o = a + along * ((double)s->opacity[segment + 1] - a);
    w->crossings += o;
    w->transmittance *= 1 - o;
    for (int i = 0; w->attenuation && i < 4; i++)
        w->forward[i] *= 1 - o * (1 - w->attenuation[i]);
}

static void keep_nearest(const struct meeting *m, uint32_t segment,
                         struct gaze *g, struct shoot_walk *w)
{
    // of two at the same distance the lower number, whatever the order
    if (m->distance > w->distance ||
        (m->distance == w->distance && segment > w->segment))
        return;
    w->distance = m->distance;
    w->along = m->along;
    w->segment = segment;
    set_end(g, m->distance);
}

INSIDE void visit(const struct shoot *s, const struct shoot_leaf *l,
                  struct gaze *g, struct shoot_walk *w, enum shoot_want want)
{
    for (unsigned hit = test_leaf(l, g); hit; hit &= hit - 1) {
        const int lane = __builtin_ctz(hit);
        struct meeting m;
        if (!meets(l, lane, g, &m))
            continue;
        if (want == SHOOT_FIRST)
            keep_nearest(&m, l->segment[lane], g, w);
        else if (s->opacity)
            pass(s, l->segment[lane], m.along, w);
        else
            w->crossings += 1;
    }
}

// --- the walk ----------------------------------------------------------------

// Everything is to be visited: leaves at once, nodes in any order.
INSIDE void walk_all(const struct shoot *s, struct gaze *g,
                     struct shoot_walk *w)
{
    uint32_t stack[SHOOT_STACK], n = 0;
    stack[n++] = 0;
    while (n > 0) {
        const struct shoot_node *node = &s->tree.node[stack[--n]];
        shoot_f4 near;
        for (unsigned hit = test_node(node, g, &near); hit; hit &= hit - 1) {
            const uint32_t child = node->child[__builtin_ctz(hit)];
            if (child & SHOOT_LEAF)
                visit(s, &s->tree.leaf[child & ~SHOOT_LEAF], g, w, SHOOT_ALL);
            else
                stack[n++] = child;
        }
    }
}

struct entry {
    uint32_t child;
    float near;
};

// Near ones first: the walk may end, or what is farther be left out.
INSIDE void walk_near(const struct shoot *s, struct gaze *g,
                      struct shoot_walk *w, enum shoot_want want)
{
    struct entry stack[SHOOT_STACK];
    uint32_t n = 0;
    stack[n++] = (struct entry){0, 0};
    while (n > 0) {
        const struct entry top = stack[--n];
        if (top.near > g->end)
            continue;
        if (top.child & SHOOT_LEAF) {
            visit(s, &s->tree.leaf[top.child & ~SHOOT_LEAF], g, w, want);
            if (want == SHOOT_CLEAR &&
                (s->opacity ? !(w->transmittance > 0) : w->crossings > 0))
                return;
            continue;
        }
        const struct shoot_node *node = &s->tree.node[top.child];
        shoot_f4 near;
        const uint32_t base = n;
        for (unsigned hit = test_node(node, g, &near); hit; hit &= hit - 1) {
            const int lane = __builtin_ctz(hit);
            const struct entry e = {node->child[lane], near[lane]};
            uint32_t at = n++;
            for (; at > base && stack[at - 1].near < e.near; at--)
                stack[at] = stack[at - 1];
            stack[at] = e;
        }
    }
}

// Without opacities crossings are all that there is to count.
static void settle(const struct shoot *s, struct shoot_walk *w)
{
    if (s->opacity)
        return;
    w->transmittance = w->crossings > 0 ? 0 : 1;
    for (int i = 0; w->attenuation && i < 4; i++)
        w->forward[i] = pow(w->attenuation[i], w->crossings);
}

// Static: what clang 14 exports of a clone has another name than what it calls
// from elsewhere.
CLONED static void walk(const struct shoot *s, struct gaze *g,
                        struct shoot_walk *w)
{
    if (w->want == SHOOT_FIRST)
        walk_near(s, g, w, SHOOT_FIRST);
    else if (w->want == SHOOT_CLEAR)
        walk_near(s, g, w, SHOOT_CLEAR);
    else
        walk_all(s, g, w);
}

void shoot_walk(const struct shoot *s, const struct shoot_ray *ray,
                struct shoot_own own, struct shoot_walk *w)
{
    w->crossings = 0;
    w->transmittance = w->forward[0] = w->forward[1] = w->forward[2] =
        w->forward[3] = 1;
    w->distance = INFINITY;
    w->along = 0;
    w->segment = UINT32_MAX;
    struct gaze g;
    if (!look(s, ray, own, &g))
        return;
    walk(s, &g, w);
    w->distance /= s->unit;
    if (w->want != SHOOT_FIRST)
        settle(s, w);
}
