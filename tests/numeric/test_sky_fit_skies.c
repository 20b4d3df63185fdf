// test_sky_fit_skies.c - lights that stand for suns and for real skies: places
// and energy of suns, the residual's promise about shading.
#include "renderer/sky.h"

#include <math.h>
#include <stdlib.h>

#include "renderer/sky_fit_lm.h"
#include "renderer/sky_fit_start.h"
#include "tests/check.h"
#include "tests/numeric/sky_maps.h"
#include "tests/numeric/sky_shading.h"
#include "tests/unit/sky_files.h"

static const double pi = 3.14159265358979323846;

// Each sky once: the Radiance files hold the same pictures.
static const char *const skies[] = {
    "OrientationLatLong.exr", "WavyLinesLatLong.exr", "blender_city.exr",
    "blender_studio.exr",     "blender_sunrise.exr",  "blender_sunset.exr",
    "pmndrs_apartment.exr",   "pmndrs_dawn.exr",      "pmndrs_studio.exr"};
enum { SKIES = sizeof skies / sizeof skies[0] };

// A sanitizer looks for bad memory, not for figures, and is slow.
#ifdef GLINT_SANITIZED
enum { EVERY = 4 };
#else
enum { EVERY = 1 };
#endif

static struct sky_map *load(const char *name)
{
    char path[1100];
    struct error err = {0};
    snprintf(path, sizeof path, "%s/%s", sky_files_data("env"), name);
    struct sky_map *m = sky_load(path, &err);
    if (!CHECK(m != NULL))
        printf("  %s\n", err.text);
    return m;
}

// --- suns ------------------------------------------------------------------

struct sun_error {
    double offset, energy; // degrees; difference over the sun's
    double ground;         // what ground a sun's blurred lobe covers, likewise
};

static struct sun_error one_sun(int x, int y, float ground, int lights)
{
    struct sky_fit fit;
    struct sky_map *m = sky_maps_new(1024, 512, ground);
    for (int k = 0; k < 3; k++)
        m->rgb[3 * (y * 1024 + x) + k] = 60000;
    CHECK(sky_maps_fit(m, lights, &fit));
    double phi = pi - 2 * pi * (x + 0.5) / 1024, theta = pi * (y + 0.5) / 512;
    double d[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
    double q =
        2 * pi / 1024 * (cos(pi * y / 512.0) - cos(pi * (y + 1) / 512.0));
    // Centre and energy of what there is beside the even ground.
    double centre[3] = {0}, energy = 0;
    for (int j = 0; j < fit.count; j++) {
        const struct sky_light *l = &fit.light[j];
        double e = l->radiance[1] * sky_lobe_omega(l->lambda);
        // Over ground: narrow lights near the sun; a sun may be shared by two.
        if (ground > 0 &&
            (l->lambda > 0.1 || sky_maps_angle(l->direction, d) > 5))
            continue;
        energy += e;
        for (int k = 0; k < 3; k++)
            centre[k] += e * l->direction[k];
    }
    if (ground <= 0)
        energy *= fit.energy_ratio[1]; // before the scaling
    sky_map_destroy(m);
    double sun = 60000 * q, blurred = sky_lobe_omega(0.2);
    return (struct sun_error){sky_maps_angle(centre, d), fabs(energy / sun - 1),
                              (double)ground * blurred / sun};
}

static void test_suns(void)
{
    // Poles, seam, both; then anywhere.
    static const int at[][2] = {{0, 0},   {700, 0},    {13, 1},   {511, 511},
                                {0, 256}, {1023, 256}, {1023, 0}, {0, 511},
                                {256, 3}, {1000, 508}};
    check_case("a sun alone: place and energy");
    uint64_t state = 5;
    struct sun_error worst = {0};
    for (int i = 0; i < 24; i += EVERY) {
        int x, y;
        if (i < 10) {
            x = at[i][0];
            y = at[i][1];
        } else {
            state = state * 6364136223846793005u + 1442695040888963407u;
            x = (int)(state >> 54);
            y = (int)(state >> 33 & 511);
        }
        struct sun_error e = one_sun(x, y, 0, 10);
        if (!CHECK_ATMOST(e.offset, 0.1) || !CHECK_ATMOST(e.energy, 0.01))
            printf("  at %d, %d\n", x, y);
        worst.offset = fmax(worst.offset, e.offset);
        worst.energy = fmax(worst.energy, e.energy);
    }
    printf("  worst: %.3f degrees, %.3f %%\n", worst.offset,
           100 * worst.energy);
}

static void test_sun_over_ground(void)
{
    check_case("a sun over an even sky: place and energy");
    static const int at[][2] = {{0, 256}, {300, 100}, {777, 30}, {513, 480}};
    for (int i = 0; i < 4; i++) {
        struct sun_error e = one_sun(at[i][0], at[i][1], 0.1f, 40);
        printf("  %.3f degrees, %.2f %% (ground %.2f %%)\n", e.offset,
               100 * e.energy, 100 * e.ground);
        CHECK_ATMOST(e.offset, 0.1);
        // The sun's light may stand for the ground around it, too.
        CHECK_ATMOST(e.energy, 0.01 + e.ground);
    }
}

// --- real skies ------------------------------------------------------------

static void test_real(void)
{
    check_case("real skies: energy, residual, shading");
    if (!sky_files_data("env")) {
        check_skip("no data");
        return;
    }
    double product = 0;
    int frames = 60;
    for (int i = 0; i < SKIES; i += EVERY) {
        static double e[180];
        struct sky_fit fit;
        struct sky_map *m = load(skies[i]);
        if (!m)
            continue;
        CHECK(sky_maps_fit(m, 40, &fit));
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(fit.energy_ratio[k], 1, 0.002);
        CHECK_NEAR(fit.predicted_error, 0.85 * fit.residual, 1e-12);
        sky_shading_errors(m, &fit, frames, e);
        double p50 = e[3 * frames / 2], p90 = e[3 * frames * 9 / 10];
        printf("  %-24s f %.4f energy %.5f %.5f %.5f, shading p50 %.4f p90 "
               "%.4f (foretold %.4f), %d iterations, %.2f s\n",
               m->name, fit.residual, fit.energy_ratio[0], fit.energy_ratio[1],
               fit.energy_ratio[2], p50, p90, fit.predicted_error,
               fit.iterations, fit.seconds);
        // What the study of the method saw with capped widths, over all skies:
        // p50 .0056, p90 .020; no single sky may be more than twice as bad.
        CHECK_ATMOST(p50, 0.012);
        CHECK_ATMOST(p90, 0.04);
        product += log(p90) * EVERY / (SKIES + EVERY - 1);
        sky_map_destroy(m);
    }
    CHECK_ATMOST(exp(product), 0.020);
    printf("  geometric mean of p90: %.4f\n", exp(product));
}

static double uncapped(const struct sky_map *m)
{
    struct sky_fit_target t;
    struct sky_fit_model *model = bytes_alloc(sizeof *model);
    sky_fit_target_init(&t, m, 40, SKY_FIT_HAIR);
    t.lambda_max = 4;
    sky_fit_model_init(model, &t, 40);
    sky_fit_start_run(model, 40, NULL);
    double start = model->f2;
    sky_fit_lm_run(model, NULL);
    CHECK(model->f2 <= start);
    double f = sqrt(model->f2);
    sky_fit_model_finish(model);
    free(model);
    sky_fit_target_finish(&t);
    return f;
}

static void test_uncapped(void)
{
    check_case("real skies: f < 0.03 at 40 lights of any width");
    if (!sky_files_data("env")) {
        check_skip("no data");
        return;
    }
    for (int i = 0; i < SKIES; i += EVERY) {
        struct sky_map *m = load(skies[i]);
        if (m && !CHECK_ATMOST(uncapped(m), 0.03))
            printf("  %s\n", skies[i]);
        sky_map_destroy(m);
    }
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    test_suns();
    test_sun_over_ground();
    test_real();
    test_uncapped();
    return check_end();
}
