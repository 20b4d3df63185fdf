// sky_fit.c - the one door to a fit: cache, target, start, refinement, and the
// way back from blurred lobes to lights.
#include "renderer/sky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "renderer/sky_cache.h"
#include "renderer/sky_fit_lm.h"
#include "renderer/sky_fit_start.h"
#include "renderer/watch.h"

static const double narrowest = 0.02; // lambda of a light
static const double p90_per_f = 0.85; // shading error's 90th percentile over
                                      // the residual f, measured on 12 skies

double sky_lobe_omega(double lambda)
{
    return sky_fit_target_omega(2 / (lambda * lambda));
}

// --- from blurred lobes to lights ------------------------------------------

// Mean cosine of exp(k cos): coth k - 1/k.
static double mean_cosine(double k)
{
    if (k < 1e-3)
        return k / 3 * (1 - k * k / 15);
    return 1 / tanh(k) - 1 / k;
}

// Its inverse: the usual first guess, then Newton.
static double inverse_mean_cosine(double r)
{
    if (!(r > 0))
        return 0;
    double k = r * (3 - r * r) / (1 - r * r);
    for (int i = 0; i < 20; i++) {
        double a = mean_cosine(k);
        double slope = k < 1e-3 ? 1.0 / 3 : 1 - a * a - 2 * a / k;
        double next = k - (a - r) / slope;
        if (!(next > 0))
            next = 0.5 * k;
        bool close = fabs(next - k) < 1e-13 * k;
        k = next;
        if (close)
            break;
    }
    return k;
}

// A blur multiplies the mean cosine of a lobe by its own, and keeps its energy.
static void unblur(const struct sky_fit_model *m, int j,
                   struct sky_light *light)
{
    double k = 2 * exp(-2 * m->lobe[j].l), kappa = k;
    double blur = m->target->blur;
    if (blur > 0)
        kappa = inverse_mean_cosine(
            fmin(1 - 1e-9, mean_cosine(k) / mean_cosine(blur)));
    kappa = fmin(kappa, 2 / (narrowest * narrowest));
    light->lambda = sqrt(2 / fmax(kappa, 1e-6));
    double scale = sky_fit_target_omega(k) / sky_lobe_omega(light->lambda);
    sky_fit_target_to_map(m->target, m->lobe[j].centre, light->direction);
    for (int c = 0; c < 3; c++)
        light->radiance[c] = m->amplitude[c][j] * scale;
}

static double light_energy(const struct sky_light *l)
{
    return (l->radiance[0] + l->radiance[1] + l->radiance[2]) *
           sky_lobe_omega(l->lambda);
}

static int by_energy(const void *a, const void *b)
{
    double x = light_energy(a), y = light_energy(b);
    return x > y ? -1 : x < y;
}

// Each channel to the energy of the map; what is left of the lights, sorted.
static void finish_lights(struct sky_fit *fit, const double map_energy[3])
{
    double energy[3] = {0};
    for (int j = 0; j < fit->count; j++)
        for (int c = 0; c < 3; c++)
            energy[c] += fit->light[j].radiance[c] *
                         sky_lobe_omega(fit->light[j].lambda);
    int kept = 0;
    for (int c = 0; c < 3; c++)
        fit->energy_ratio[c] =
            map_energy[c] > 0 ? energy[c] / map_energy[c] : 1;
    for (int j = 0; j < fit->count; j++) {
        struct sky_light l = fit->light[j];
        for (int c = 0; c < 3; c++)
            l.radiance[c] *= energy[c] > 0 ? map_energy[c] / energy[c] : 0;
        if (light_energy(&l) > 0)
            fit->light[kept++] = l;
    }
    fit->count = kept;
    qsort(fit->light, (size_t)kept, sizeof fit->light[0], by_energy);
}

// --- the fit ---------------------------------------------------------------

// What hair would see of lights that were fitted to something else: their
// residual under the hair objective.  Narrow lobes add their widths' squares.
static double hair_residual(const struct sky_fit *fit,
                            const struct sky_map *map)
{
    struct sky_fit_target t;
    struct sky_fit_model m;
    sky_fit_target_init(&t, map, fit->count, SKY_FIT_HAIR);
    sky_fit_model_init(&m, &t, fit->count);
    for (int j = 0; j < fit->count; j++) {
        const struct sky_light *l = &fit->light[j];
        double kappa = 2 / (l->lambda * l->lambda);
        double k =
            inverse_mean_cosine(mean_cosine(kappa) * mean_cosine(t.blur));
        sky_fit_target_from_map(&t, l->direction, m.lobe[j].centre);
        m.lobe[j].l = 0.5 * log(2 / fmax(k, 1e-6));
        for (int c = 0; c < 3; c++)
            m.amplitude[c][j] = l->radiance[c] * sky_fit_target_omega(kappa) /
                                sky_fit_target_omega(k);
    }
    m.count = fit->count;
    sky_fit_model_update(&m, 0);
    sky_fit_model_residual(&m);
    double f = sqrt(m.f2);
    sky_fit_model_finish(&m);
    sky_fit_target_finish(&t);
    return f;
}

static void run(const struct sky_fit_job *job, struct sky_fit *fit)
{
    const struct sky_map *map = job->map;
    const int lights = job->lights;
    const enum sky_fit_mode mode = job->mode;
    struct sky_fit_target t;
    sky_fit_target_init(&t, map, lights, mode);
    for (int c = 0; c < 3; c++)
        fit->energy_ratio[c] = 1;
    if (!t.black) {
        struct sky_fit_model m;
        sky_fit_model_init(&m, &t, lights);
        sky_fit_start_run(&m, lights, job->watch);
        fit->iterations = sky_fit_lm_run(&m, job->watch);
        fit->count = m.count;
        for (int j = 0; j < m.count; j++)
            unblur(&m, j, &fit->light[j]);
        fit->residual = sqrt(m.f2);
        sky_fit_model_finish(&m);
        finish_lights(fit, t.map_energy);
        fit->predicted_error =
            p90_per_f * (mode == SKY_FIT_HAIR || fit->count == 0
                             ? fit->residual
                             : hair_residual(fit, map));
    }
    sky_fit_target_finish(&t);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool sky_fit_do(const struct sky_fit_job *job, struct sky_fit *fit,
                struct error *err)
{
    const int lights = job->lights;
    memset(fit, 0, sizeof *fit);
    if (lights < 1 || lights > SKY_LIGHTS_MAX)
        return error_set(err, "range", "sky.lights",
                         "sky.lights: %d is not within [1, %d]", lights,
                         SKY_LIGHTS_MAX);
    struct sky_cache_key key = {.lights = lights, .mode = job->mode};
    memcpy(key.sha256, job->map->sha256, sizeof key.sha256);
    if (job->cache_dir && sky_cache_read(job->cache_dir, &key, fit))
        return true;
    double begin = now();
    run(job, fit);
    fit->seconds = now() - begin;
    if (watch_cut(job->watch)) {
        memset(fit, 0, sizeof *fit);
        return false;
    }
    if (job->cache_dir)
        sky_cache_write(job->cache_dir, &key, fit);
    return true;
}

bool sky_fit_run(const struct sky_map *map, int lights, enum sky_fit_mode mode,
                 const char *cache_dir, struct sky_fit *fit, struct error *err)
{
    const struct sky_fit_job job = {map, lights, mode, cache_dir, NULL};
    return sky_fit_do(&job, fit, err);
}

void sky_fit_eval(const struct sky_fit *fit, const double direction[3],
                  double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int j = 0; j < fit->count; j++) {
        const struct sky_light *l = &fit->light[j];
        double cosine = direction[0] * l->direction[0] +
                        direction[1] * l->direction[1] +
                        direction[2] * l->direction[2];
        double g = exp(2 * (cosine - 1) / (l->lambda * l->lambda));
        for (int c = 0; c < 3; c++)
            rgb[c] += g * l->radiance[c];
    }
}
