// test_shoot_lobe.c - averages of the ray shooter: random hair of which the
// mean number of crossings is known, lobes of which the distribution is known,
// and the same bits from any number of threads.
//
// Seeds are fixed, so a result never changes by chance; tolerances are the
// standard errors that the data themselves show, times 4.
#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/shoot.h"
#include "tests/check.h"
#include "tests/numeric/shoot_brute.h"

static double uniform(uint64_t *state, double lo, double hi)
{
    return shoot_brute_uniform(state, lo, hi);
}

// --- random hair -------------------------------------------------------------

enum { SEGMENTS = 4000, GROOMS = 32 };
static const double half = 1, length = 0.15, width = 0.01; // of the box

// Segments with middles anywhere in the box |x| < half + 0.1, directions
// anywhere, or all along `along`.  Every place whose distance from the box's
// faces is more than length / 2 + width has the same density of them.
static struct groom *random_hair(uint64_t *seed, const double *along)
{
    struct groom *g = shoot_brute_groom(SEGMENTS, 2, (float)width);
    for (uint32_t k = 0; k < SEGMENTS; k++) {
        double d[3];
        shoot_brute_aim(seed, d);
        if (along)
            memcpy(d, along, sizeof d);
        for (int c = 0; c < 3; c++) {
            double x = uniform(seed, -half - 0.1, half + 0.1);
            g->position[6 * k + (unsigned)c] = (float)(x - d[c] * length / 2);
            g->position[6 * k + 3 + (unsigned)c] =
                (float)(x + d[c] * length / 2);
        }
    }
    return g;
}

// Area of hair (length x diameter) in a unit of volume.
static double density(void)
{
    return SEGMENTS * length * width / pow(2 * (half + 0.1), 3);
}

// A ray through the middle part, of length 1: from a place near one side.
static struct shoot_ray inner_ray(uint64_t *seed)
{
    struct shoot_ray r = {.reach = 1, .segment = UINT32_MAX};
    shoot_brute_aim(seed, r.direction);
    for (int c = 0; c < 3; c++)
        r.origin[c] = uniform(seed, -0.45, 0.45) - 0.5 * r.direction[c];
    return r;
}

struct mean { // of independent values
    double n, sum, sum2;
};

static void mean_add(struct mean *m, double x)
{
    m->n++;
    m->sum += x;
    m->sum2 += x * x;
}

static double mean_error(const struct mean *m)
{
    double a = m->sum / m->n;
    return sqrt(fmax(0, m->sum2 / m->n - a * a) / (m->n - 1));
}

// Within 4 standard errors, and those small enough to say something.
static void check_mean(const struct mean *m, double want, double small)
{
    double got = m->sum / m->n, error = mean_error(m);
    CHECK_ATMOST(error, small * want);
    CHECK_ATMOST(fabs(got - want), 4 * error);
}

// A ray crosses an area of rho <sin> in a unit of length: each segment shows
// it length x width x the sine of their angle; the sine's mean is pi / 4.
static void test_isotropic(void)
{
    check_case("isotropic hair is crossed rho pi/4 times a length");
    uint64_t seed = 21;
    struct mean n = {0}, clear = {0};
    for (int i = 0; i < GROOMS; i++) {
        struct groom *g = random_hair(&seed, NULL);
        struct shoot *s = shoot_brute_scene(g);
        double crossings = 0, passes = 0;
        enum { RAYS = 8000 };
        for (int k = 0; k < RAYS; k++) {
            struct shoot_ray r = inner_ray(&seed);
            struct shoot_hit hit;
            shoot_ray(s, &r, &hit);
            crossings += hit.crossings / RAYS;
            passes += hit.transmittance / RAYS;
        }
        mean_add(&n, crossings);
        mean_add(&clear, passes);
        shoot_destroy(s);
        groom_destroy(g);
    }
    const double want = density() * M_PI / 4;
    check_mean(&n, want, 0.01);
    check_case("a Poisson number of crossings leaves e^-n unblocked");
    // binomial, really, of 4000: less by a factor 1 - n^2 / 8000, 2e-5
    check_mean(&clear, exp(-want), 0.01);
}

static void test_parallel(void)
{
    check_case("parallel hair is crossed rho sin(angle) times a length");
    const double degrees[] = {90, 50, 15};
    uint64_t seed = 22;
    for (int a = 0; a < 3; a++) {
        double sine = sin(degrees[a] * M_PI / 180);
        struct mean n = {0};
        for (int i = 0; i < GROOMS; i++) {
            double z[3], x[3], dot = 0, across = 0;
            shoot_brute_aim(&seed, z);
            shoot_brute_aim(&seed, x);
            for (int c = 0; c < 3; c++)
                dot += x[c] * z[c];
            for (int c = 0; c < 3; c++) {
                x[c] -= dot * z[c];
                across += x[c] * x[c];
            }
            struct groom *g = random_hair(&seed, z);
            struct shoot *s = shoot_brute_scene(g);
            double crossings = 0;
            enum { RAYS = 1500 };
            for (int k = 0; k < RAYS; k++) {
                struct shoot_ray r = inner_ray(&seed);
                for (int c = 0; c < 3; c++) {
                    r.origin[c] += 0.5 * r.direction[c];
                    r.direction[c] = sine * x[c] / sqrt(across) +
                                     sqrt(1 - sine * sine) * z[c];
                    r.origin[c] -= 0.5 * r.direction[c];
                }
                struct shoot_hit hit;
                shoot_ray(s, &r, &hit);
                crossings += hit.crossings / RAYS;
            }
            mean_add(&n, crossings);
            shoot_destroy(s);
            groom_destroy(g);
        }
        check_mean(&n, density() * sine, 0.03);
    }
}

// Lobes in isotropic hair: whatever the lobe, E[a^N] = e^(-n (1 - a)).
static void test_forward(void)
{
    check_case("lobes' forward transmittance is e^(-n (1 - a))");
    enum { LOBES = 100 };
    const double attenuation[4] = {0, 0.3, 0.7, 1};
    uint64_t seed = 23;
    struct mean m[4] = {{0}}, n = {0};
    for (int i = 0; i < GROOMS; i++) {
        struct groom *g = random_hair(&seed, NULL);
        struct shoot *s = shoot_brute_scene(g);
        struct shoot_ray from[LOBES];
        struct shoot_lobe lobe[LOBES];
        for (int k = 0; k < LOBES; k++) {
            from[k] = inner_ray(&seed);
            memset(from[k].origin, 0, sizeof from[k].origin);
            for (int c = 0; c < 3; c++) // 0.9 is then inside all around
                from[k].origin[c] = uniform(&seed, -0.1, 0.1);
            from[k].reach = 0.9;
            memcpy(lobe[k].direction, from[k].direction,
                   sizeof lobe[k].direction);
            lobe[k].lambda = exp(uniform(&seed, -3, 0));
        }
        shoot_lobes(s, from, attenuation, 32, (uint64_t)i * LOBES, lobe, LOBES);
        struct shoot_lobe clear = lobe[7]; // without attenuations: the same
        shoot_lobe(s, &from[7], NULL, 32, (uint64_t)i * LOBES + 7, &clear);
        CHECK_NEAR(clear.transmittance, lobe[7].transmittance, 0);
        CHECK_NEAR(clear.deviation, lobe[7].deviation, 0);
        CHECK(isnan(clear.crossings) && isnan(clear.forward[3]));
        double sum[4] = {0}, crossings = 0;
        for (int k = 0; k < LOBES; k++) {
            CHECK_NEAR(lobe[k].forward[0], lobe[k].transmittance, 1e-14);
            for (int a = 0; a < 4; a++)
                sum[a] += lobe[k].forward[a] / LOBES;
            crossings += lobe[k].crossings / LOBES;
        }
        for (int a = 0; a < 4; a++)
            mean_add(&m[a], sum[a]);
        mean_add(&n, crossings);
        shoot_destroy(s);
        groom_destroy(g);
    }
    const double mean = 0.9 * density() * M_PI / 4;
    check_mean(&n, mean, 0.03);
    for (int a = 0; a < 3; a++)
        check_mean(&m[a], exp(-mean * (1 - attenuation[a])), 0.03);
    CHECK_NEAR(m[3].sum / m[3].n, 1, 1e-12);
}

// --- lobes -------------------------------------------------------------------

static const double lambdas[] = {1e-3, 0.05, 0.3, 1, 2, 50};
enum { LAMBDAS = 6, RAYS = 1000 };

// u of the distribution's inverse, from 1 - cos: equal shares lie between
// equal steps of it.
static double share_of(double lack, double lambda)
{
    double l2 = lambda * lambda;
    return expm1(-2 * lack / l2) / expm1(-4 / l2);
}

static void test_density(void)
{
    check_case("lobe directions are distributed as the SRBF");
    for (int l = 0; l < LAMBDAS; l++) {
        struct shoot_lobe lobe = {.lambda = lambdas[l]};
        uint64_t seed = 31 + (uint64_t)l;
        shoot_brute_aim(&seed, lobe.direction);
        int count[RAYS] = {0}, outside = 0;
        double cosine = 0, norm = 0;
        for (int i = 0; i < RAYS; i++) {
            double d[3], c = 0, lack = 0;
            shoot_lobe_direction(&lobe, i, RAYS, seed, d);
            for (int k = 0; k < 3; k++) {
                double e = d[k] - lobe.direction[k];
                c += d[k] * lobe.direction[k];
                lack += e * e / 2; // of unit vectors: 1 - cos, nothing lost
            }
            norm = fmax(norm, fabs(lack - (1 - c)));
            int stratum = (int)(share_of(lack, lambdas[l]) * RAYS);
            if (stratum < 0 || stratum >= RAYS)
                outside++;
            else
                count[stratum]++;
            cosine += c / RAYS;
        }
        // one ray in each of 1000 equal shares; but for rounding at an edge
        int wrong = 0;
        for (int i = 0; i < RAYS; i++)
            wrong += count[i] != 1;
        CHECK(outside == 0 && wrong <= 2);
        CHECK_ATMOST(norm, 1e-14); // they are unit vectors
        // mean cosine of this density, concentration k: coth k - 1 / k, here
        // by its series where the difference cancels; the strata leave an
        // error of order 1 / rays of the cosine's spread
        double k = 2 / (lambdas[l] * lambdas[l]);
        double want = k < 0.01 ? k / 3 : 1 / tanh(k) - 1 / k;
        CHECK_ATMOST(fabs(cosine - want), 2.0 / RAYS * fmin(1 / k, 1));
    }
}

static void test_azimuth(void)
{
    check_case("lobe directions go evenly around");
    struct shoot_lobe lobe = {.direction = {0, 0.6, -0.8}, .lambda = 0.5};
    for (int harmonic = 1; harmonic <= 8; harmonic++) {
        double x = 0, y = 0;
        for (int i = 0; i < RAYS; i++) {
            double d[3];
            shoot_lobe_direction(&lobe, i, RAYS, 5, d);
            double phi = atan2(d[0], 0.8 * d[1] + 0.6 * d[2]);
            x += cos(harmonic * phi) / RAYS;
            y += sin(harmonic * phi) / RAYS;
        }
        // independent angles would leave 0.03; a lattice far less
        CHECK_ATMOST(hypot(x, y), 0.01);
    }
    double a[3], b[3];
    shoot_lobe_direction(&lobe, 3, RAYS, 5, a);
    shoot_lobe_direction(&lobe, 3, RAYS, 6, b);
    CHECK(memcmp(a, b, sizeof a) != 0);
}

// A round head seen from outside covers a cap around its middle: what part of
// a lobe at it is blocked is the distribution function.
static void test_cap(void)
{
    check_case("a lobe's blocked part is the part of it on the head");
    struct groom *g = shoot_brute_groom(1, 2, 0.001f);
    g->position[2] = 900;
    g->position[5] = 901;
    g->head.present = true;
    for (int c = 0; c < 3; c++)
        g->head.radius[c] = 3;
    struct shoot *s = shoot_brute_scene(g);
    struct shoot_ray from = {.origin = {4, 0, 3}, // 5 away: the sine is 0.6
                             .reach = INFINITY,
                             .segment = UINT32_MAX};
    for (int l = 1; l < LAMBDAS; l++) {
        struct shoot_lobe lobe = {.direction = {-0.8, 0, -0.6},
                                  .lambda = lambdas[l]};
        shoot_lobe(s, &from, (double[4]){0, 0.5, 0.9, 1}, 2000, 9, &lobe);
        double blocked = share_of(1 - 0.8, lambdas[l]);
        CHECK_NEAR(lobe.transmittance, 1 - blocked, 1.0 / 2000 + 1e-12);
        CHECK_NEAR(lobe.forward[3], lobe.transmittance, 0);
        CHECK_NEAR(lobe.crossings, 1e9 * (1 - lobe.transmittance), 1e-12);
        double t = lobe.transmittance;
        CHECK_NEAR(lobe.deviation, sqrt(t * (1 - t) / 1999), 1e-12);
    }
    shoot_destroy(s);
    groom_destroy(g);
}

// The stated deviation against the scatter of many seeds: not too small, and
// of the right order.
static void test_deviation(void)
{
    check_case("a lobe's deviation covers its scatter");
    uint64_t seed = 41;
    struct groom *g = random_hair(&seed, NULL);
    struct shoot *s = shoot_brute_scene(g);
    const double none[4] = {0};
    double scatter2 = 0, deviation2 = 0;
    for (int i = 0; i < 40; i++) {
        struct shoot_ray from = inner_ray(&seed);
        struct shoot_lobe lobe = {.lambda = 0.5};
        memcpy(lobe.direction, from.direction, sizeof from.direction);
        from.reach = 2;
        struct mean m = {0};
        double stated2 = 0;
        for (uint64_t k = 0; k < 30; k++) {
            shoot_lobe(s, &from, none, 64, k, &lobe);
            mean_add(&m, lobe.transmittance);
            stated2 += lobe.deviation * lobe.deviation / 30;
        }
        scatter2 += mean_error(&m) * mean_error(&m) * m.n;
        deviation2 += stated2;
    }
    CHECK(scatter2 > 0);
    // 40 x 30 values: the scatter is known to some 3 %
    CHECK_ATMOST(sqrt(scatter2 / deviation2), 1.1);
    CHECK_ATMOST(0.2, sqrt(scatter2 / deviation2));
    shoot_destroy(s);
    groom_destroy(g);
}

// --- threads -----------------------------------------------------------------

enum { LOBES = 200 };

static void run_all(const struct groom *g, int cores, struct shoot_lobe *lobe)
{
    cpu_set_t all, some;
    sched_getaffinity(0, sizeof all, &all);
    CPU_ZERO(&some);
    int n = 0;
    for (size_t i = 0; i < CPU_SETSIZE && n < cores; i++)
        if (CPU_ISSET(i, &all)) {
            CPU_SET(i, &some);
            n++;
        }
    sched_setaffinity(0, sizeof some, &some);
    struct shoot *s = shoot_brute_scene(g);
    struct shoot_ray from[LOBES];
    uint64_t seed = 51;
    for (int i = 0; i < LOBES; i++) {
        from[i] = inner_ray(&seed);
        memset(&lobe[i], 0, sizeof lobe[i]);
        memcpy(lobe[i].direction, from[i].direction, sizeof from[i].direction);
        lobe[i].lambda = 0.3;
    }
    shoot_lobes(s, from, (double[4]){0.1, 0.5, 0.9, 1}, 50, 7, lobe, LOBES);
    struct shoot_lobe one = lobe[LOBES - 1];
    shoot_lobe(s, &from[LOBES - 1], (double[4]){0.1, 0.5, 0.9, 1}, 50,
               7 + LOBES - 1, &one);
    CHECK(memcmp(&one, &lobe[LOBES - 1], sizeof one) == 0);
    shoot_destroy(s);
    sched_setaffinity(0, sizeof all, &all);
}

// Opacities make every sum and product depend on the order of the tree; 24,000
// segments are more than one thread's part of it.
static void test_threads(void)
{
    check_case("lobes have the same bits on one core, on two, and again");
    cpu_set_t set;
    sched_getaffinity(0, sizeof set, &set);
    if (CPU_COUNT(&set) < 2) {
        check_skip("this process may use one core only");
        return;
    }
    enum { STRANDS = 3000, POINTS = 9 };
    struct groom *g = shoot_brute_groom(STRANDS, POINTS, 0.02f);
    g->opacity = bytes_zalloc(g->points, sizeof *g->opacity);
    uint64_t seed = 52;
    for (uint32_t i = 0; i < g->points; i++) {
        g->opacity[i] = (float)uniform(&seed, 0, 1);
        for (uint32_t c = 0; c < 3; c++)
            g->position[3 * i + c] =
                i % POINTS == 0 ? (float)uniform(&seed, -1, 1)
                                : g->position[3 * i + c - 3] +
                                      (float)uniform(&seed, -0.05, 0.05);
    }
    static struct shoot_lobe one[LOBES], two[LOBES], again[LOBES];
    run_all(g, 1, one);
    run_all(g, 2, two);
    run_all(g, 2, again);
    CHECK(memcmp(one, two, sizeof one) == 0);
    CHECK(memcmp(two, again, sizeof one) == 0);
    double mean = 0;
    for (int i = 0; i < LOBES; i++)
        mean += one[i].crossings / LOBES;
    CHECK(mean > 1); // or nothing was compared
    groom_destroy(g);
}

int main(void)
{
    test_isotropic();
    test_parallel();
    test_forward();
    test_density();
    test_azimuth();
    test_cap();
    test_deviation();
    test_threads();
    return check_end();
}
