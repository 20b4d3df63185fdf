// bench_shoot.c - build time and rays per second of the ray shooter, one JSON
// line a groom and kind of query.  Not part of make test.
//   make build/tests/bench/bench_shoot && build/tests/bench/bench_shoot
//       [SOURCE[:DIAMETER] ...]
// The cpu figures are of processor time over all threads: they hold on a busy
// machine too.  Origins: strand points spread over the groom, each with a lobe
// of rays in a random direction; all cores this process may use.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/shoot.h"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double uniform(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15u; // splitmix64
    uint64_t x = *state;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    return (double)(x >> 11) * 0x1p-53;
}

static void aim(uint64_t *state, double d[3])
{
    double z = 2 * uniform(state) - 1, phi = 2 * M_PI * uniform(state);
    d[0] = sqrt(1 - z * z) * cos(phi);
    d[1] = sqrt(1 - z * z) * sin(phi);
    d[2] = z;
}

static struct shoot_ray origin(const struct groom *g, const struct shoot *s,
                               uint64_t *state)
{
    uint32_t k = (uint32_t)(uniform(state) * g->strands);
    uint32_t n = g->first[k + 1] - g->first[k] - 1;
    struct shoot_ray r = {.reach = INFINITY};
    r.segment = g->first[k] + (uint32_t)(uniform(state) * n);
    struct shoot_point p;
    shoot_point(s, r.segment, uniform(state), &p);
    memcpy(r.origin, p.position, sizeof r.origin);
    aim(state, r.direction);
    return r;
}

static void bench_lobes(const struct groom *g, const struct shoot *s,
                        double lambda)
{
    enum { COUNT = 1000, RAYS = 64 };
    static struct shoot_ray from[COUNT];
    static struct shoot_lobe lobe[COUNT];
    const double attenuation[4] = {0.3, 0.6, 0.85, 0.95};
    uint64_t state = 1;
    for (int i = 0; i < COUNT; i++) {
        from[i] = origin(g, s, &state);
        lobe[i].lambda = lambda;
        aim(&state, lobe[i].direction);
    }
    double start = now(), cpu = cpu_now();
    shoot_lobes(s, from, attenuation, RAYS, 1, lobe, COUNT);
    double seconds = now() - start, crossings = 0, passes = 0;
    cpu = cpu_now() - cpu;
    int open = 0;
    for (int i = 0; i < COUNT; i++) {
        passes += lobe[i].transmittance / COUNT;
        if (lobe[i].crossings < 1e6) {
            crossings += lobe[i].crossings;
            open++;
        }
    }
    printf("{\"groom\":\"%s\",\"query\":\"lobes\",\"lambda\":%g,"
           "\"rays_per_s\":%.4g,\"rays_per_cpu_s\":%.4g,"
           "\"transmittance\":%.4f,"
           "\"crossings_clear_of_head\":%.2f}\n",
           g->name, lambda, COUNT * RAYS / seconds, COUNT * RAYS / cpu, passes,
           crossings / open);
}

static void bench_single(const struct groom *g, const struct shoot *s,
                         bool first)
{
    enum { COUNT = 50000 };
    uint64_t state = 2;
    struct shoot_ray *ray = malloc(COUNT * sizeof *ray);
    for (int i = 0; i < COUNT; i++)
        ray[i] = origin(g, s, &state);
    double start = cpu_now(), met = 0;
    for (int i = 0; i < COUNT; i++) {
        uint32_t segment;
        double along;
        met += first ? shoot_first(s, &ray[i], &segment, &along) < INFINITY
                     : shoot_transmittance(s, &ray[i]) < 1;
    }
    double seconds = cpu_now() - start;
    printf("{\"groom\":\"%s\",\"query\":\"%s\",\"threads\":1,"
           "\"rays_per_cpu_s\":%.4g,\"met\":%.4f}\n",
           g->name, first ? "first" : "transmittance", COUNT / seconds,
           met / COUNT);
    free(ray);
}

static bool bench(const char *source)
{
    char name[512];
    struct error err = {0};
    struct params p;
    params_defaults(&p);
    snprintf(name, sizeof name, "%s", source);
    char *colon = strrchr(name, ':');
    if (colon && strchr("0123456789.", colon[1]) && colon[1]) {
        p.hair.diameter = strtof(colon + 1, NULL);
        *colon = 0;
    }
    struct groom *g = groom_open(name, &err);
    if (!g) {
        fprintf(stderr, "bench_shoot: %s\n", err.text);
        return false;
    }
    double best = INFINITY, best_cpu = INFINITY; // of three
    struct shoot *s = NULL;
    for (int i = 0; i < 3; i++) {
        shoot_destroy(s);
        double start = now(), cpu = cpu_now();
        s = shoot_create(g, &p, &err);
        best = fmin(best, now() - start);
        best_cpu = fmin(best_cpu, cpu_now() - cpu);
    }
    if (!s) {
        fprintf(stderr, "bench_shoot: %s\n", err.text);
        groom_destroy(g);
        return false;
    }
    printf("{\"groom\":\"%s\",\"query\":\"build\",\"segments\":%u,"
           "\"diameter\":%g,\"ms\":%.1f,\"cpu_ms\":%.1f,\"megabytes\":%.1f}\n",
           g->name, g->points - g->strands, shoot_diameter(s), 1e3 * best,
           1e3 * best_cpu, (double)shoot_bytes(s) / 1e6);
    const double lambda[] = {0.05, 0.2, 1};
    for (int i = 0; i < 3; i++)
        bench_lobes(g, s, lambda[i]);
    bench_single(g, s, false);
    bench_single(g, s, true);
    fflush(stdout);
    shoot_destroy(s);
    groom_destroy(g);
    return true;
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {"builtin:animation", "builtin:straight",
                                        "../shared/data/hair/straight.hair"};
    bool ok = true;
    if (argc < 2)
        for (int i = 0; i < 3; i++)
            ok &= bench(usual[i]);
    for (int i = 1; i < argc; i++)
        ok &= bench(argv[i]);
    return ok ? 0 : 1;
}
