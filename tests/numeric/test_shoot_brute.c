// test_shoot_brute.c - rays against strands: the hierarchy loses nothing and
// adds nothing, by brute force over all segments.
#include <math.h>

#include "renderer/shoot.h"
#include "tests/check.h"
#include "tests/numeric/shoot_brute.h"

static double uniform(uint64_t *state, double lo, double hi)
{
    return shoot_brute_uniform(state, lo, hi);
}

static void put(struct groom *g, uint32_t i, double x, double y, double z)
{
    g->position[3 * i] = (float)x;
    g->position[3 * i + 1] = (float)y;
    g->position[3 * i + 2] = (float)z;
}

// Random walks in a box of half width `size` around `centre`: steps from none
// to long, diameters from nothing to thick, opacities.
static struct groom *tangle(uint64_t seed, double size, double centre)
{
    enum { STRANDS = 150, POINTS = 9 };
    struct groom *g = shoot_brute_groom(STRANDS, POINTS, 0);
    g->diameter = bytes_zalloc(g->points, sizeof *g->diameter);
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    for (uint32_t k = 0; k < STRANDS; k++) {
        double p[3], step = size * exp(uniform(&seed, -5, -0.5));
        for (int c = 0; c < 3; c++)
            p[c] = uniform(&seed, -size, size);
        for (uint32_t i = k * POINTS; i < (k + 1) * POINTS; i++) {
            put(g, i, centre + p[0], centre + p[1], centre + p[2]);
            g->diameter[i] = (float)(size * exp(uniform(&seed, -7, -1)));
            g->opacity[i] = (float)uniform(&seed, 0, 1);
            bool rest = uniform(&seed, 0, 1) < 0.1; // a zero-length segment
            for (int c = 0; c < 3; c++)
                p[c] += rest ? 0 : uniform(&seed, -step, step);
        }
    }
    return g;
}

// Dyadic lattice: strands along the axes, joints and edges hit exactly.
static struct groom *lattice(void)
{
    enum { SIDE = 6, POINTS = 5 };
    struct groom *g = shoot_brute_groom(3 * SIDE * SIDE, POINTS, 0.25f);
    for (uint32_t k = 0; k < g->strands; k++)
        for (uint32_t i = 0; i < POINTS; i++) {
            double v[3];
            int axis = (int)k / (SIDE * SIDE);
            v[axis] = 2.0 * i - 3;
            v[(axis + 1) % 3] = k % SIDE;
            v[(axis + 2) % 3] = k / SIDE % SIDE;
            put(g, k * POINTS + i, v[0], v[1], v[2]);
        }
    return g;
}

// A quarter well outside, a quarter somewhere inside, the rest on a strand.
static void pick_origin(const struct groom *g, uint64_t *seed, double size,
                        struct shoot_ray *r)
{
    double kind = uniform(seed, 0, 4), u = uniform(seed, 0, 1);
    uint32_t k = (uint32_t)uniform(seed, 0, g->strands);
    uint32_t n = g->first[k + 1] - g->first[k] - 1;
    uint32_t i = g->first[k] + (uint32_t)uniform(seed, 0, n);
    const float *p = g->position + 3 * (size_t)i;
    for (int c = 0; c < 3; c++) {
        r->origin[c] = (double)p[c] + u * ((double)p[c + 3] - (double)p[c]);
        if (kind < 1)
            r->origin[c] += uniform(seed, -20, 20) * size;
        else if (kind < 2)
            r->origin[c] += uniform(seed, -1, 1) * size;
    }
    r->segment = kind < 2 ? UINT32_MAX : i;
}

// A third along axes, some exactly along a segment, a tenth anywhere, the rest
// near a point of a strand (at it, where a segment begins, either answer would
// be right).
static void pick_direction(const struct groom *g, uint64_t *seed, double size,
                           struct shoot_ray *r)
{
    double kind = uniform(seed, 0, 10), n = 0, to[3];
    uint32_t i = (uint32_t)uniform(seed, 0, g->points - 1);
    const float *p = g->position + 3 * (size_t)i;
    shoot_brute_aim(seed, r->direction);
    if (kind < 3) {
        int axis = (int)kind;
        double sign = uniform(seed, -1, 1) < 0 ? -1 : 1;
        for (int c = 0; c < 3; c++)
            r->direction[c] = c == axis ? sign : 0;
        return;
    }
    if (kind > 9)
        return;
    for (int c = 0; c < 3; c++) {
        double near = (double)p[c] + uniform(seed, -0.01, 0.01) * size;
        to[c] =
            kind < 4 ? (double)p[c + 3] - (double)p[c] : near - r->origin[c];
        n += to[c] * to[c];
    }
    if (n > 0)
        for (int c = 0; c < 3; c++)
            r->direction[c] = to[c] / sqrt(n);
}

struct tally {
    double met, wrong;
};

// Counts are sums of few terms of which each is right to a few bits.
static bool same(double a, double b)
{
    return a == b || fabs(a - b) <= 1e-12 * fmax(1, fabs(b));
}

static void compare(const struct groom *g, const struct shoot *s,
                    const struct shoot_ray *r, struct tally *t)
{
    struct shoot_brute want = shoot_brute(g, r);
    struct shoot_hit hit;
    uint32_t segment;
    double along;
    shoot_ray(s, r, &hit);
    double distance = shoot_first(s, r, &segment, &along);
    bool ok = same(hit.crossings, want.crossings) &&
              same(hit.transmittance, want.transmittance) &&
              same(shoot_transmittance(s, r), want.transmittance) &&
              segment == want.segment && !hit.head;
    if (!g->opacity)
        ok &= hit.crossings == want.crossings;
    // some roundings of the coordinates, more where the ray is nearly parallel
    double scale = fabs(r->origin[0]) + fabs(r->origin[1]) +
                   fabs(r->origin[2]) + want.distance;
    if (want.segment != UINT32_MAX)
        ok &= fabs(along - want.along) <= 1e-9 &&
              fabs(distance - want.distance) <= 1e-12 * scale;
    else
        ok &= distance == INFINITY;
    if (!ok && t->wrong++ < 3)
        printf("  from %g %g %g to %g %g %g (segment %u): crossings %.17g, "
               "want %.17g; first %u at %.17g, want %u at %.17g\n",
               r->origin[0], r->origin[1], r->origin[2], r->direction[0],
               r->direction[1], r->direction[2], r->segment, hit.crossings,
               want.crossings, segment, distance, want.segment, want.distance);
    t->met += want.segment != UINT32_MAX;
}

typedef void pick(const struct groom *g, uint64_t *seed, double size,
                  struct shoot_ray *r);

static void pick_any(const struct groom *g, uint64_t *seed, double size,
                     struct shoot_ray *r)
{
    pick_origin(g, seed, size, r);
    pick_direction(g, seed, size, r);
    if (uniform(seed, 0, 1) < 0.2)
        r->reach = uniform(seed, 0, size);
}

// Along an axis, all numbers multiples of 1/8: exact, so that even the ribbons'
// edges and ends, of which the lattice's are such, are met alike.
static void pick_exact(const struct groom *g, uint64_t *seed, double size,
                       struct shoot_ray *r)
{
    (void)g;
    int axis = (int)uniform(seed, 0, 3);
    double sign = uniform(seed, -1, 1) < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++) {
        r->origin[c] = floor(uniform(seed, -3.5, 5.5) * size * 8) / 8;
        r->direction[c] = c == axis ? sign : 0;
    }
    if (uniform(seed, 0, 1) < 0.3)
        r->reach = floor(uniform(seed, 0, 64)) / 8;
    r->segment = UINT32_MAX;
}

static void against_brute(struct groom *g, uint64_t seed, double size,
                          pick *choose)
{
    enum { RAYS = 1500 };
    struct shoot *s = shoot_brute_scene(g);
    struct tally t = {0, 0};
    for (int i = 0; i < RAYS; i++) {
        struct shoot_ray r = {.reach = INFINITY};
        choose(g, &seed, size, &r);
        compare(g, s, &r, &t);
    }
    CHECK(t.wrong == 0);
    CHECK(t.met > 0.25 * RAYS); // or nothing was tested
    shoot_destroy(s);
    groom_destroy(g);
}

static void test_brute(void)
{
    check_case("shoot equals brute force in a tangle");
    for (uint64_t seed = 1; seed <= 4; seed++)
        against_brute(tangle(seed, 1, 0), seed, 1, pick_any);
    check_case("shoot equals brute force far from the origin");
    against_brute(tangle(5, 1, 1000), 5, 1, pick_any);
    check_case("shoot equals brute force in huge coordinates");
    against_brute(tangle(6, 1e30, 0), 6, 1e30, pick_any);
    check_case("shoot equals brute force in tiny coordinates");
    against_brute(tangle(7, 1e-9, 0), 7, 1e-9, pick_any);
    check_case("shoot equals brute force on a lattice, edges included");
    against_brute(lattice(), 8, 1, pick_exact);
}

int main(void)
{
    test_brute();
    return check_end();
}
