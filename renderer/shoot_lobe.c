// shoot_lobe.c - what an SRBF light sends through the hair to a point: means
// over directions drawn from the lobe.
#include "renderer/shoot.h"

#include <math.h>

#include "renderer/shoot_threads.h"
#include "renderer/shoot_walk.h"

static const double head_crossings = 1e9; // stands for: no way through

// Uniform in (0, 1) from splitmix64's mixing (Steele, Lea and Flood 2014).
static double uniform(uint64_t seed, uint64_t stream)
{
    uint64_t x = seed * 2 + stream;
    x = (x + 1) * 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    return ((double)(x >> 11) + 0.5) * 0x1p-53;
}

// --- directions --------------------------------------------------------------

struct frame {
    double x[3], y[3], z[3];
    double half;  // lambda^2 / 2
    double spent; // e^(-4 / lambda^2) - 1
    double shift[2];
};

static struct frame frame_of(const struct shoot_lobe *lobe, uint64_t seed)
{
    struct frame f;
    int k = 0;
    for (int i = 0; i < 3; i++) {
        f.z[i] = lobe->direction[i];
        if (fabs(f.z[i]) < fabs(f.z[k]))
            k = i;
    }
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double n = sqrt(f.z[i] * f.z[i] + f.z[j] * f.z[j]);
    f.x[k] = 0;
    f.x[i] = -f.z[j] / n;
    f.x[j] = f.z[i] / n;
    for (int c = 0; c < 3; c++) {
        const int u = (c + 1) % 3, v = (c + 2) % 3;
        f.y[c] = f.z[u] * f.x[v] - f.z[v] * f.x[u];
    }
    const double l2 = lobe->lambda * lobe->lambda;
    f.half = l2 / 2;
    f.spent = expm1(-4 / l2);
    f.shift[0] = uniform(seed, 0);
    f.shift[1] = uniform(seed, 1);
    return f;
}

// The distribution function of the density exp(2 (cos - 1) / lambda^2) (Xu
// 2011, eq 2) inverted: 1 - cos = -(lambda^2 / 2) ln(u + (1 - u) e^(-4 /
// lambda^2)).  u in `rays` strata, the angle by the golden section: together a
// lattice with low discrepancy at any number of rays.
static void direction(const struct frame *f, int i, int rays, double out[3])
{
    const double golden = 0.6180339887498949;
    const double u = (i + f->shift[0]) / rays;
    const double turn = i * golden + f->shift[1];
    const double phi = 2 * M_PI * (turn - floor(turn));
    const double lack = -f->half * log1p((1 - u) * f->spent); // 1 - cos
    const double cosine = 1 - lack, sine = sqrt(fmax(0, lack * (2 - lack)));
    const double x = sine * cos(phi), y = sine * sin(phi);
    double n = 0;
    for (int c = 0; c < 3; c++) {
        out[c] = x * f->x[c] + y * f->y[c] + cosine * f->z[c];
        n += out[c] * out[c];
    }
    for (int c = 0; c < 3; c++)
        out[c] /= sqrt(n);
}

void shoot_lobe_direction(const struct shoot_lobe *lobe, int i, int rays,
                          uint64_t seed, double out[3])
{
    const struct frame f = frame_of(lobe, seed);
    direction(&f, i, rays, out);
}

// --- means -------------------------------------------------------------------

void shoot_lobe(const struct shoot *s, const struct shoot_ray *from,
                const double attenuation[4], int rays, uint64_t seed,
                struct shoot_lobe *lobe)
{
    const struct frame f = frame_of(lobe, seed);
    const struct shoot_own own = shoot_own(s, from->segment);
    struct shoot_ray ray = *from;
    struct shoot_walk w = {.want = attenuation ? SHOOT_ALL : SHOOT_CLEAR,
                           .attenuation = attenuation};
    double crossings = 0, sum = 0, sum2 = 0, forward[4] = {0};
    for (int i = 0; i < rays; i++) {
        direction(&f, i, rays, ray.direction);
        if (shoot_head(s, &ray) < INFINITY) {
            crossings += head_crossings;
            continue;
        }
        shoot_walk(s, &ray, own, &w);
        crossings += w.crossings;
        sum += w.transmittance;
        sum2 += w.transmittance * w.transmittance;
        for (int m = 0; m < 4; m++)
            forward[m] += w.forward[m];
    }
    lobe->crossings = attenuation ? crossings / rays : NAN;
    lobe->transmittance = sum / rays;
    for (int m = 0; m < 4; m++)
        lobe->forward[m] = attenuation ? forward[m] / rays : NAN;
    const double mean = sum / rays;
    lobe->deviation =
        rays < 2 ? INFINITY
                 : sqrt(fmax(0, sum2 / rays - mean * mean) / (rays - 1));
}

struct many {
    const struct shoot *s;
    const struct shoot_ray *from;
    const double *attenuation;
    int rays;
    uint64_t seed;
    struct shoot_lobe *lobes;
};

static void one_of_many(void *context, size_t i)
{
    const struct many *m = context;
    shoot_lobe(m->s, &m->from[i], m->attenuation, m->rays, m->seed + i,
               &m->lobes[i]);
}

void shoot_lobes(const struct shoot *s, const struct shoot_ray *from,
                 const double attenuation[4], int rays, uint64_t seed,
                 struct shoot_lobe *lobes, size_t count)
{
    struct many m = {s, from, attenuation, rays, seed, lobes};
    shoot_threads(count, one_of_many, &m);
}
