// test_shoot.c - rays against strands: the conventions of shoot.h, where a
// number can be written down.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/place.h"
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

static struct shoot_ray ray_at(double x, double y, double z)
{
    return (struct shoot_ray){.origin = {x, y, z},
                              .direction = {1, 0, 0},
                              .reach = INFINITY,
                              .segment = UINT32_MAX};
}

static double crossings(const struct shoot *s, const struct shoot_ray *r)
{
    struct shoot_hit hit;
    shoot_ray(s, r, &hit);
    return hit.crossings;
}

// --- conventions -------------------------------------------------------------

// Many segments in one place: nothing to split by, the tree must still end.
static void test_heap(void)
{
    check_case("shoot takes any number of equal segments");
    struct groom *g = shoot_brute_groom(5000, 3, 0.1f);
    for (uint32_t i = 0; i < g->points; i++)
        put(g, i, 0, i % 3, 0);
    struct shoot *s = shoot_brute_scene(g);
    struct shoot_ray r = ray_at(-2, 0.5, 0);
    uint32_t segment;
    double along;
    CHECK(crossings(s, &r) == 5000);
    CHECK_NEAR(shoot_first(s, &r, &segment, &along), 2, 1e-14);
    CHECK(segment == 0); // the lowest of equals
    shoot_destroy(s);
    for (uint32_t i = 0; i < g->points; i++)
        put(g, i, 3, 3, 3);
    s = shoot_brute_scene(g); // no length at all
    r = ray_at(0, 3, 3);
    CHECK(crossings(s, &r) == 0);
    CHECK(shoot_first(s, &r, &segment, &along) == INFINITY);
    shoot_destroy(s);
    groom_destroy(g);
}

// One straight strand of four segments along y at x = 0.
static void test_ribbon(void)
{
    check_case("shoot cuts ribbons square and counts a joint once");
    struct groom *g = shoot_brute_groom(1, 5, 0.5f);
    for (uint32_t i = 0; i < 5; i++)
        put(g, i, 0, i, 0);
    struct shoot *s = shoot_brute_scene(g);
    const double y[] = {-0.001, 0, 0.5, 1, 2, 3, 3.999, 4, 4.2};
    const double want[] = {0, 1, 1, 1, 1, 1, 1, 0, 0};
    for (int i = 0; i < 9; i++) {
        struct shoot_ray r = ray_at(-1, y[i], 0.25); // on the edge
        CHECK_NEAR(crossings(s, &r), want[i], 0);
        r.origin[2] = 0.2500001;
        CHECK_NEAR(crossings(s, &r), 0, 0);
    }
    struct shoot_ray r = ray_at(-1, 1.25, 0.1);
    uint32_t segment;
    double along;
    CHECK_NEAR(shoot_first(s, &r, &segment, &along), 1, 0);
    CHECK(segment == 1);
    CHECK_NEAR(along, 0.25, 0);
    struct shoot_point p;
    shoot_point(s, segment, along, &p);
    CHECK_NEAR(p.position[1], 1.25, 0);
    CHECK_NEAR(p.tangent[1], 1, 0);
    CHECK_NEAR(p.diameter, 0.5, 0);
    CHECK(p.strand == 0 && p.opacity == 1);
    r = ray_at(0, -1, 0); // along the strand
    memcpy(r.direction, (double[3]){0, 1, 0}, sizeof r.direction);
    CHECK_NEAR(crossings(s, &r), 0, 0);
    shoot_destroy(s);
    groom_destroy(g);
}

// Rays along segments, through them, in directions where rounding leaves a
// little that is not along: it must not be taken for a ribbon seen from its
// end.
static void test_lengthways(void)
{
    check_case("shoot meets no segment that lies along the ray");
    uint64_t seed = 13;
    int met = 0, before = 0;
    for (int i = 0; i < 2000; i++) {
        struct groom *g = shoot_brute_groom(1, 2, 0.25f);
        double d[3], n = 0;
        for (uint32_t c = 0; c < 6; c++)
            g->position[c] = (float)uniform(&seed, -1, 1);
        struct shoot_ray r = ray_at(0, 0, 0);
        for (int c = 0; c < 3; c++) {
            d[c] = (double)g->position[3 + c] - (double)g->position[c];
            n += d[c] * d[c];
        }
        for (int c = 0; c < 3; c++) {
            r.direction[c] = d[c] / sqrt(n);
            r.origin[c] = (double)g->position[c] - 0.3 * d[c];
        }
        struct shoot *s = shoot_brute_scene(g);
        met += crossings(s, &r) != 0;
        // turned by 1e-6 rad about its beginning, it is met
        int k = fabs(d[0]) < fabs(d[1]) ? 0 : 1;
        r.origin[k] -= 1e-6;
        for (int c = 0; c < 3; c++)
            r.direction[c] = (double)g->position[c] + 0.01 * d[c] - r.origin[c];
        n = sqrt(r.direction[0] * r.direction[0] +
                 r.direction[1] * r.direction[1] +
                 r.direction[2] * r.direction[2]);
        for (int c = 0; c < 3; c++)
            r.direction[c] /= n;
        before += crossings(s, &r) != 1;
        shoot_destroy(s);
        groom_destroy(g);
    }
    CHECK(met == 0);
    CHECK(before == 0);
}

// Rays that touch the edge of a ribbon from inside, along the face of its box,
// at coordinates that floats do not hold exactly.
static void test_grazing(void)
{
    check_case("shoot loses no ribbon whose edge is grazed");
    uint64_t seed = 14;
    int wrong = 0;
    for (int i = 0; i < 3000; i++) {
        struct groom *g = shoot_brute_groom(1, 2, 0.1f);
        uint32_t x = (uint32_t)i % 3, y = (x + 1) % 3, z = (x + 2) % 3;
        for (uint32_t c = 0; c < 3; c++)
            g->position[c] = g->position[3 + c] = (float)uniform(&seed, -1, 1);
        g->position[3 + x] += 0.5f;
        double sign = i % 2 ? 1 : -1, phi = uniform(&seed, 0.1, 3);
        struct shoot_ray r = ray_at(0, 0, 0);
        r.direction[x] = cos(phi);
        r.direction[y] = sin(phi);
        r.direction[z] = 0;
        double back = uniform(&seed, 0, 3);
        r.origin[x] = (double)g->position[x] + 0.2 - back * cos(phi);
        r.origin[y] = (double)g->position[y] - back * sin(phi);
        r.origin[z] =
            (double)g->position[z] + sign * ((double)0.1f / 2) * (1 - 1e-12);
        struct shoot *s = shoot_brute_scene(g);
        wrong += crossings(s, &r) != 1;
        r.origin[z] += sign * 1e-12; // and does not gain one
        wrong += crossings(s, &r) != 0;
        shoot_destroy(s);
        groom_destroy(g);
    }
    CHECK(wrong == 0);
}

// Ten strands across the ray at x = 1..10.
static struct groom *ladder(float diameter)
{
    struct groom *g = shoot_brute_groom(10, 2, diameter);
    for (uint32_t k = 0; k < 10; k++) {
        put(g, 2 * k, k + 1, -5, 0);
        put(g, 2 * k + 1, k + 1, 5, 0);
    }
    return g;
}

static void test_reach(void)
{
    check_case(
        "shoot counts what is nearer than reach, before the origin none");
    struct groom *g = ladder(0.25f);
    struct shoot *s = shoot_brute_scene(g);
    struct shoot_ray r = ray_at(0, 0, 0);
    const double reach[] = {0, 0.5, 1, 1.5, 4, 4.0001, 1e300, INFINITY};
    const double want[] = {0, 0, 0, 1, 3, 4, 10, 10};
    for (int i = 0; i < 8; i++) {
        r.reach = reach[i];
        CHECK_NEAR(crossings(s, &r), want[i], 0);
        CHECK_NEAR(shoot_transmittance(s, &r), want[i] == 0, 0);
    }
    r = ray_at(3.5, 0, 0);
    CHECK_NEAR(crossings(s, &r), 7, 0);
    r = ray_at(-1e8, 0, 0);
    CHECK_NEAR(crossings(s, &r), 10, 0);
    r.reach = NAN; // nothing is nearer than that
    CHECK_NEAR(crossings(s, &r), 0, 0);
    shoot_destroy(s);
    groom_destroy(g);
}

static void test_opacity(void)
{
    check_case("shoot weights crossings by opacity");
    struct groom *g = ladder(0.25f);
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    double sum = 0, product = 1, forward = 1, a = 0.6;
    for (uint32_t k = 0; k < 10; k++) {
        g->opacity[2 * k] = (float)k / 16;
        g->opacity[2 * k + 1] = (float)k / 32;
        double o = k / 16.0 * 0.75 + k / 32.0 * 0.25; // a quarter along
        sum += o;
        product *= 1 - o;
        forward *= 1 - o * (1 - a);
    }
    struct shoot *s = shoot_brute_scene(g);
    struct shoot_ray r = ray_at(0, -2.5, 0);
    struct shoot_hit hit;
    shoot_ray(s, &r, &hit);
    CHECK_NEAR(hit.crossings, sum, 1e-14);
    CHECK_NEAR(hit.transmittance, product, 1e-14);
    CHECK_NEAR(shoot_transmittance(s, &r), product, 1e-14);
    struct shoot_lobe lobe = {.direction = {1, 0, 0}, .lambda = 1e-9};
    shoot_lobe(s, &r, (double[4]){0, a, 1, 0.5}, 7, 1, &lobe);
    // the lobe's rays meet the strands within 1e-7 of where the ray does
    CHECK_NEAR(lobe.crossings, sum, 1e-6);
    CHECK_NEAR(lobe.transmittance, product, 1e-6);
    CHECK_NEAR(lobe.forward[0], product, 1e-6);
    CHECK_NEAR(lobe.forward[1], forward, 1e-6);
    CHECK_NEAR(lobe.forward[2], 1, 0);
    shoot_destroy(s);
    struct params p;
    params_defaults(&p); // use_opacity is off: the array is not looked at
    s = shoot_create(g, &p, NULL);
    CHECK(s && crossings(s, &r) == 10);
    shoot_destroy(s);
    free(g->opacity);
    g->opacity = NULL;
    g->default_opacity = 0.5f;
    p.hair.use_opacity = 1;
    s = shoot_create(g, &p, NULL);
    CHECK(s && crossings(s, &r) == 5);
    shoot_destroy(s);
    groom_destroy(g);
}

// A hairpin: up at x = 0, over, down at x = 1; another strand at x = 2.
static void test_own(void)
{
    check_case("shoot leaves out the own strand nearer than 8 diameters");
    struct groom *g = shoot_brute_groom(2, 4, 0);
    put(g, 0, 0, 0, -4);
    put(g, 1, 0, 0, 4);
    put(g, 2, 1, 0, 4);
    put(g, 3, 1, 0, -4);
    for (uint32_t i = 4; i < 8; i++)
        put(g, i, 2, 0, 4.0 - i);
    for (int thick = 0; thick < 2; thick++) {
        g->default_diameter = thick ? 0.1251f : 0.1249f;
        struct shoot *s = shoot_brute_scene(g);
        struct shoot_ray r = ray_at(0, 0, -0.5);
        CHECK_NEAR(crossings(s, &r), 2, 0);
        uint32_t segment;
        double along;
        for (uint32_t on = 0; on < 3; on++) {
            r.segment = on; // any segment of the strand means the strand
            CHECK_NEAR(crossings(s, &r), thick ? 1 : 2, 0);
            shoot_first(s, &r, &segment, &along);
            CHECK(segment == (thick ? 4u : 2u));
        }
        r.segment = 5; // the other one's far part is not its own
        CHECK_NEAR(crossings(s, &r), 2, 0);
        shoot_destroy(s);
    }
    groom_destroy(g);
}

// --- head --------------------------------------------------------------------

static const double radius[3] = {1, 2, 3}, centre[3] = {0.5, -1, 2};

static struct groom *bald(void) // a ladder far away, and a head
{
    struct groom *g = ladder(0.25f);
    for (uint32_t i = 0; i < g->points; i++)
        g->position[3 * i + 2] = 4000;
    g->head.present = true;
    for (int c = 0; c < 3; c++) {
        g->head.radius[c] = (float)radius[c];
        g->head.centre[c] = (float)centre[c];
    }
    return g;
}

// The nearest place of the ray to the head, where the head is a unit sphere.
static double clearance(const struct shoot_ray *r, double *at)
{
    double o[3], d[3], od = 0, dd = 0, n = 0;
    for (int c = 0; c < 3; c++) {
        o[c] = (r->origin[c] - centre[c]) / radius[c];
        d[c] = r->direction[c] / radius[c];
        od += o[c] * d[c];
        dd += d[c] * d[c];
    }
    *at = fmax(0, -od / dd);
    for (int c = 0; c < 3; c++)
        n += (o[c] + *at * d[c]) * (o[c] + *at * d[c]);
    return sqrt(n);
}

static void head_outside(const struct shoot *s)
{
    uint64_t seed = 11;
    int met = 0, wrong = 0;
    for (int i = 0; i < 3000; i++) {
        struct shoot_ray r = ray_at(0, 0, 0);
        shoot_brute_aim(&seed, r.origin);
        for (int c = 0; c < 3; c++)
            r.origin[c] = centre[c] + r.origin[c] * radius[c] *
                                          exp(uniform(&seed, 1e-3, 3));
        double n = 0;
        for (int c = 0; c < 3; c++) { // at it, or past it
            double to = centre[c] + radius[c] * uniform(&seed, -1.5, 1.5);
            r.direction[c] = to - r.origin[c];
            n += r.direction[c] * r.direction[c];
        }
        for (int c = 0; c < 3; c++)
            r.direction[c] /= sqrt(n);
        double at, near = clearance(&r, &at);
        if (fabs(near - 1) < 1e-9)
            continue; // either is right
        struct shoot_hit hit;
        shoot_ray(s, &r, &hit);
        bool ok = hit.head == (near < 1);
        ok &= !hit.head || hit.transmittance == 0;
        if (hit.head) {
            uint32_t segment;
            double along, t = shoot_first(s, &r, &segment, &along);
            n = 0;
            for (int c = 0; c < 3; c++) {
                double x = r.origin[c] + t * r.direction[c] - centre[c];
                n += x * x / (radius[c] * radius[c]);
            }
            // t is the first of two places on the surface
            ok &= fabs(n - 1) < 1e-10 && t < at && segment == UINT32_MAX;
            r.reach = t * (1 - 1e-9);
            shoot_ray(s, &r, &hit);
            ok &= !hit.head;
            met++;
        }
        wrong += !ok;
    }
    CHECK(wrong == 0);
    CHECK(met > 600 && met < 2400);
}

// On the surface, and inside by as much as roots may be: what leads outwards
// passes, what leads inwards does not.
static void head_inside(const struct shoot *s, double level)
{
    uint64_t seed = 12;
    int wrong = 0;
    for (int i = 0; i < 1000; i++) {
        struct shoot_ray r = ray_at(0, 0, 0);
        double on[3], slope = 0;
        shoot_brute_aim(&seed, on);
        shoot_brute_aim(&seed, r.direction);
        for (int c = 0; c < 3; c++) {
            r.origin[c] = centre[c] + level * radius[c] * on[c];
            slope += r.direction[c] * on[c] / radius[c];
        }
        struct shoot_hit hit;
        shoot_ray(s, &r, &hit);
        uint32_t segment;
        double along, t = shoot_first(s, &r, &segment, &along);
        wrong += fabs(slope) > 1e-6 &&
                 (hit.head != (slope < 0) || (slope < 0 && t != 0));
    }
    CHECK(wrong == 0);
}

static void test_head(void)
{
    check_case("shoot meets the head from outside");
    struct groom *g = bald();
    struct shoot *s = shoot_brute_scene(g);
    head_outside(s);
    check_case("shoot takes an origin in the head as lying on it");
    head_inside(s, 1 - 1e-12);
    head_inside(s, 0.97);
    head_inside(s, 0.3);
    shoot_destroy(s);
    check_case("shoot counts fibres before the head only");
    for (uint32_t i = 0; i < g->points; i++)
        g->position[3 * i + 2] = 0;
    g->head.centre[0] = 5.5f; // from 4.5 to 6.5 along x
    g->head.centre[1] = g->head.centre[2] = 0;
    s = shoot_brute_scene(g);
    struct shoot_ray r = ray_at(0, 0, 0);
    struct shoot_hit hit;
    shoot_ray(s, &r, &hit);
    CHECK(hit.head && hit.crossings == 4 && hit.transmittance == 0);
    CHECK(shoot_transmittance(s, &r) == 0);
    uint32_t segment;
    double along;
    CHECK_NEAR(shoot_first(s, &r, &segment, &along), 1, 0);
    r.origin[0] = 4.25;
    CHECK_NEAR(shoot_first(s, &r, &segment, &along), 0.25, 1e-14);
    CHECK(segment == UINT32_MAX);
    shoot_destroy(s);
    groom_destroy(g);
}

// --- placement ---------------------------------------------------------------

static void test_place(void)
{
    check_case("shoot stands where the picture's strands stand");
    struct groom *g = shoot_brute_groom(1, 2, 0.5f);
    put(g, 0, 1, 2, 3);
    put(g, 1, 2, 5, 4);
    struct params p;
    params_defaults(&p);
    p.hair.scale = 3;
    for (int up = 1; up <= 3; up++) {
        p.hair.up = up;
        // x up: y, z, x; y up: x, -z, y; scaled by 3
        const float want[3][3] = {{6, 9, 3}, {3, -9, 6}, {3, 6, 9}};
        float at[3];
        place_point(g, &p, 0, at);
        struct shoot *s = shoot_create(g, &p, NULL);
        struct shoot_point a;
        shoot_point(s, 0, 0, &a);
        for (int c = 0; c < 3; c++) {
            CHECK(at[c] == want[up - 1][c]);
            CHECK_NEAR(a.position[c], (double)at[c], 0);
        }
        CHECK_NEAR(a.diameter, 1.5, 0);
        CHECK_NEAR(shoot_diameter(s), 1.5, 1e-15);
        shoot_destroy(s);
    }
    g->default_diameter = 0; // the automatic one
    struct shoot *s = shoot_create(g, &p, NULL);
    CHECK_NEAR(shoot_diameter(s), 3 * (double)groom_auto_diameter(g), 1e-6);
    shoot_destroy(s);
    p.hair.diameter = 0.25f;
    s = shoot_create(g, &p, NULL);
    CHECK_NEAR(shoot_diameter(s), 0.75, 1e-15);
    shoot_destroy(s);
    groom_destroy(g);
}

static void test_refused(void)
{
    check_case("shoot refuses what does not fit");
    struct error err = {0};
    struct params p;
    params_defaults(&p);
    struct groom *g = shoot_brute_groom(2, 2, 0.5f);
    put(g, 2, 1e38, 0, 0);
    p.hair.scale = 100;
    CHECK(!shoot_create(g, &p, &err));
    CHECK_STR(err.code, "range");
    CHECK(strstr(err.text, "hair.scale: 100") != NULL);
    CHECK(strstr(err.text, "point 2") != NULL);
    uint32_t points = g->points;
    g->points = (8u << 20) + 1;
    CHECK(!shoot_create(g, &p, &err));
    CHECK_STR(err.code, "limit");
    g->points = points;
    groom_destroy(g);
}

int main(void)
{
    test_heap();
    test_ribbon();
    test_lengthways();
    test_grazing();
    test_reach();
    test_opacity();
    test_own();
    test_head();
    test_place();
    test_refused();
    return check_end();
}
