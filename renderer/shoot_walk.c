// shoot_walk.c - one ray through the tree.  Single precision and eight at a
// time where only something may be left out, double precision where it is
// decided.
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

// Short loops over axes and lanes: unrolled, which -O2 alone does not.
#ifdef __clang__
#define UNROLLED _Pragma("clang loop unroll(full)")
#else
#define UNROLLED _Pragma("GCC unroll 8")
#endif

typedef float f8 __attribute__((vector_size(32)));
typedef int32_t i8 __attribute__((vector_size(32)));

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

// --- eight at a time ---------------------------------------------------------

// Vectors travel by pointer: by value their way of passing differs between
// processors, and compilers warn of it.
INSIDE void take_smaller(f8 *a, const f8 *b)
{
    const i8 m = *b < *a;
    *a = (f8)(((i8)*b & m) | ((i8)*a & ~m));
}

INSIDE void take_larger(f8 *a, const f8 *b)
{
    const i8 m = *b > *a;
    *a = (f8)(((i8)*b & m) | ((i8)*a & ~m));
}

INSIDE void load(const float *from, f8 *out)
{
    memcpy(out, from, sizeof *out);
}

// Children whose box the ray meets (-1 or 0), and where it enters them.
INSIDE void test_node(const struct shoot_node *n, const struct gaze *g,
                      f8 *near, int32_t hit[SHOOT_LANES])
{
    const f8 zero = {0};
    f8 from = zero, to = zero + g->end, t;
    UNROLLED
    for (int k = 0; k < 3; k++) {
        load(n->side[g->behind[k]][k], &t);
        t = (t - g->o[k]) * g->inverse[k];
        take_larger(&from, &t);
        load(n->side[1 - g->behind[k]][k], &t);
        t = (t - g->o[k]) * g->inverse[k];
        take_smaller(&to, &t);
    }
    *near = from;
    // both distances are right to 3 x 2^-24 of themselves
    const i8 met = from <= to * (1 + 0x1p-21f);
    memcpy(hit, &met, sizeof met);
}

// Segments nearer to the ray than their radius (-1 or 0): all that are, and few
// others.
INSIDE void test_leaf(const struct shoot_leaf *l, const struct gaze *g,
                      int32_t hit[SHOOT_LANES])
{
    f8 p[2] = {{0}}, e[2] = {{0}};
    UNROLLED
    for (int k = 0; k < 3; k++) {
        f8 a, b;
        load(l->a[k], &a);
        load(l->b[k], &b);
        b -= a;
        a -= g->o[k];
        UNROLLED
        for (int i = 0; i < 2; i++) {
            p[i] += a * g->a[i][k];
            e[i] += b * g->a[i][k];
        }
    }
    const f8 zero = {0}, one = zero + 1;
    f8 u = -(p[0] * e[0] + p[1] * e[1]) / (e[0] * e[0] + e[1] * e[1] + 1e-30f);
    take_smaller(&u, &one);
    take_larger(&u, &zero);
    const f8 x = p[0] + u * e[0], y = p[1] + u * e[1];
    f8 reach;
    load(l->radius, &reach);
    reach += (float)SHOOT_REACH_MARGIN;
    const i8 met = x * x + y * y <= reach * reach;
    memcpy(hit, &met, sizeof met);
}

// --- one segment, decided ----------------------------------------------------

struct meeting {
    double distance, along; // scene units
};

INSIDE bool meets(const struct shoot *s, const struct shoot_leaf *l,
                  uint32_t lane, const struct gaze *g, struct meeting *m)
{
    double q[3], e[3];
    UNROLLED
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
    if (!(m->along >= 0 && m->along < 1))
        return false;
    const uint32_t segment = l->segment[lane];
    double radius = (double)l->radius[lane];
    if (s->tapered) {
        const float *p = s->point + 4 * (size_t)segment;
        const double a = (double)p[3] / 2, b = (double)p[7] / 2;
        radius = a + m->along * (b - a);
    }
    const double area = qx * ey - qy * ex;
    if (area * area > radius * radius * length2)
        return false;
    m->distance = dot(q, g->direction) + m->along * dot(e, g->direction);
    if (!(m->distance > 0 && m->distance < g->reach))
        return false;
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

INSIDE void meet(const struct shoot *s, const struct shoot_leaf *l,
                 uint32_t lane, struct gaze *g, struct shoot_walk *w)
{
    struct meeting m;
    if (!meets(s, l, lane, g, &m))
        return;
    if (w->want == SHOOT_FIRST)
        keep_nearest(&m, l->segment[lane], g, w);
    else if (s->opacity)
        pass(s, l->segment[lane], m.along, w);
    else
        w->crossings += 1;
}

// --- the walk ----------------------------------------------------------------

INSIDE void fetch(const void *four_lines)
{
    UNROLLED
    for (int i = 0; i < 4; i++)
        __builtin_prefetch((const char *)four_lines + 64 * i);
}

// Everything is to be visited, in any order.  A walk's time is waiting, for
// memory and for branches foreseen wrongly: so nodes are taken by the batch,
// leaves and segments are collected, each asked for before it is looked at, and
// what a test leaves is kept by adding 0 or 1 to a count.
enum {
    BATCH = 8,
    LEAVES = 32,
    STACK = BATCH + BATCH * (SHOOT_LANES - 1) * SHOOT_DEPTH
};

struct pending {
    uint32_t nodes, leaves;
    uint32_t leaf[LEAVES + 2 * SHOOT_LANES];
    uint32_t lane[(LEAVES + 2 * SHOOT_LANES) * SHOOT_LANES]; // of all leaves
    uint32_t node[STACK + SHOOT_LANES];
};

INSIDE void drain(const struct shoot *s, struct gaze *g, struct pending *p,
                  struct shoot_walk *w)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < p->leaves; i++) {
        int32_t hit[SHOOT_LANES];
        test_leaf(&s->tree.leaf[p->leaf[i]], g, hit);
        UNROLLED
        for (uint32_t k = 0; k < SHOOT_LANES; k++) {
            p->lane[n] = p->leaf[i] * SHOOT_LANES + k;
            n -= (uint32_t)hit[k];
        }
    }
    p->leaves = 0;
    for (uint32_t i = 0; i < n; i++)
        meet(s, &s->tree.leaf[p->lane[i] / SHOOT_LANES],
             p->lane[i] % SHOOT_LANES, g, w);
}

INSIDE void take_node(const struct shoot *s, uint32_t index,
                      const struct gaze *g, struct pending *p)
{
    const struct shoot_node *node = &s->tree.node[index];
    uint32_t leaves = p->leaves;
    int32_t hit[SHOOT_LANES];
    f8 near;
    test_node(node, g, &near, hit);
    UNROLLED
    for (int k = 0; k < SHOOT_LANES; k++) {
        const uint32_t child = node->child[k], leaf = child >> 31;
        const uint32_t met = (uint32_t)hit[k] & 1;
        p->node[p->nodes] = child;
        p->leaf[p->leaves] = child & ~SHOOT_LEAF;
        p->nodes += met & ~leaf;
        p->leaves += met & leaf;
    }
    for (; leaves < p->leaves; leaves++)
        fetch(&s->tree.leaf[p->leaf[leaves]]);
}

INSIDE void walk_all(const struct shoot *s, struct gaze *g,
                     struct shoot_walk *w)
{
    struct pending p;
    p.node[0] = 0;
    p.nodes = 1;
    p.leaves = 0;
    while (p.nodes > 0) {
        uint32_t now[BATCH], n = p.nodes < BATCH ? p.nodes : BATCH;
        p.nodes -= n;
        for (uint32_t i = 0; i < n; i++) {
            now[i] = p.node[p.nodes + i];
            fetch(&s->tree.node[now[i]]);
        }
        for (uint32_t i = 0; i < n; i++) {
            take_node(s, now[i], g, &p);
            if (p.leaves >= LEAVES)
                drain(s, g, &p, w);
        }
    }
    drain(s, g, &p, w);
}

struct entry {
    uint32_t child;
    float near;
};

struct queue { // the nearest last
    uint32_t entries;
    struct entry entry[SHOOT_LANES * (SHOOT_DEPTH + 1)];
};

INSIDE void open_node(const struct shoot_node *node, const struct gaze *g,
                      struct queue *q)
{
    int32_t hit[SHOOT_LANES];
    f8 near;
    test_node(node, g, &near, hit);
    const uint32_t base = q->entries;
    UNROLLED
    for (int k = 0; k < SHOOT_LANES; k++) {
        if (!hit[k])
            continue;
        const struct entry e = {node->child[k], near[k]};
        uint32_t at = q->entries++;
        for (; at > base && q->entry[at - 1].near < e.near; at--)
            q->entry[at] = q->entry[at - 1];
        q->entry[at] = e;
    }
}

INSIDE void open_leaf(const struct shoot *s, const struct shoot_leaf *l,
                      struct gaze *g, struct shoot_walk *w)
{
    int32_t hit[SHOOT_LANES];
    test_leaf(l, g, hit);
    UNROLLED
    for (uint32_t k = 0; k < SHOOT_LANES; k++)
        if (hit[k])
            meet(s, l, k, g, w);
}

static bool nothing_passes(const struct shoot *s, const struct shoot_walk *w)
{
    return s->opacity ? !(w->transmittance > 0) : w->crossings > 0;
}

// Near ones first: the walk may end, or what is farther be left out.
INSIDE void walk_near(const struct shoot *s, struct gaze *g,
                      struct shoot_walk *w)
{
    struct queue q;
    q.entries = 0;
    open_node(&s->tree.node[0], g, &q);
    while (q.entries > 0) {
        const struct entry top = q.entry[--q.entries];
        if (top.near > g->end)
            continue;
        if (!(top.child & SHOOT_LEAF)) {
            open_node(&s->tree.node[top.child], g, &q);
            continue;
        }
        open_leaf(s, &s->tree.leaf[top.child & ~SHOOT_LEAF], g, w);
        if (w->want == SHOOT_CLEAR && nothing_passes(s, w))
            return;
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
    if (w->want == SHOOT_ALL)
        walk_all(s, g, w);
    else
        walk_near(s, g, w);
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
