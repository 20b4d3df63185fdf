// The last pass against double precision: tone curves, the head's light, the
// sky behind, and the sky's tint on each of them.
#include "tests/check.h"
#include "tests/render/scene.h"

// Rounding to 8 bits is wrong by half a step; pow of two drivers differs by
// far less than another quarter.
static const double STEP = 0.75;

static void base(struct params *p)
{
    scene_params(p);
    p->quality.samples = 1;
    p->quality.light_bound = 0;
}

static double srgb(double x)
{
    x = fmin(fmax(x, 0), 1);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static double filmic(double x)
{
    return srgb(x * (x + 0.35) / (x * (x + 0.9) + 0.35));
}

// Largest error, in 8-bit steps, of what pixel (x, y) of a picture shows.
static double error_at(struct renderer *r, const struct params *p,
                       const int pixel[2], const double want[3])
{
    struct buf b = {0};
    struct error err = {0};
    double most = 0;
    if (!renderer_read_display(r, &b, &err))
        return INFINITY;
    const uint8_t *at =
        b.data + 4 * (size_t)(pixel[1] * p->image.width + pixel[0]);
    for (int c = 0; c < 3; c++) {
        const double x = want[c] * exp2(p->view.exposure);
        const double shown = p->view.curve ? filmic(x) : srgb(x);
        most = fmax(most, fabs(at[c] - 255 * shown));
    }
    buf_finish(&b);
    return most;
}

// The background's colour goes through the curve and nothing else: hundreds of
// values from the darks' straight piece to beyond white.
static void curves(void)
{
    struct params p;
    base(&p);
    struct renderer *r =
        scene_renderer(scene_lock(1, 6), scene_two_lamps(), &p);
    const int corner[2] = {0, 0};
    scene_finish(r);
    for (int curve = 0; curve < 2; curve++) {
        double worst = 0;
        check_case(curve ? "filmic is the double's" : "sRGB is the double's");
        p.view.curve = curve;
        for (int k = 0; k < 150; k++) {
            double want[3];
            for (int c = 0; c < 3; c++) {
                p.view.colour[c] = (float)(3e-4 * exp(0.02 * (3 * k + c)));
                want[c] = (double)p.view.colour[c];
            }
            p.view.exposure = 0.01f * (float)(k % 7);
            renderer_set_params(r, &p);
            worst = fmax(worst, error_at(r, &p, corner, want));
        }
        CHECK_ATMOST(worst, STEP);
        CHECK(worst > 0.4); // else nothing was rounded
    }
    renderer_destroy(r);
}

// Irradiance of the lights at the head's normal, softened (display.comp).
static void head_light(const struct sky_fit *fit, const struct params *p,
                       const double n[3], double out[3])
{
    double e[3] = {0, 0, 0};
    for (int j = 0; j < fit->count; j++) {
        const struct sky_light *l = &fit->light[j];
        const double soft = 0.5 * l->lambda;
        const double c = n[0] * l->direction[0] + n[1] * l->direction[1] +
                         n[2] * l->direction[2];
        const double lit = 0.5 * (c + sqrt(c * c + soft * soft)) /
                           sqrt(1 + 0.25 * soft * soft);
        for (int k = 0; k < 3; k++)
            e[k] += l->radiance[k] * sky_lobe_omega(l->lambda) * lit;
    }
    for (int k = 0; k < 3; k++)
        out[k] = e[k] * 0.09 / M_PI * exp2(p->tint.exposure) *
                 (double)p->tint.colour[k];
}

// Where the ray through a pixel's middle meets a sphere about the origin; the
// camera stands on -y.  False: it misses, or passes near the edge.
static bool normal_at(const struct params *p, const int pixel[2], double radius,
                      double n[3])
{
    const double t = tan(0.5 * (double)p->camera.fov * M_PI / 180);
    const double w = p->image.width, h = p->image.height;
    const double d[3] = {(2 * (pixel[0] + 0.5) / w - 1) * t * w / h, 1,
                         (1 - 2 * (pixel[1] + 0.5) / h) * t};
    const double o = (double)p->camera.eye[1];
    const double a = d[0] * d[0] + 1 + d[2] * d[2], b = o;
    const double q = b * b - a * (o * o - radius * radius);
    if (q < 0.05 * b * b * radius * radius / (o * o))
        return false;
    const double s = (-b - sqrt(q)) / a;
    for (int c = 0; c < 3; c++)
        n[c] = (s * d[c] + (c == 1 ? o : 0)) / radius;
    return true;
}

static double head_error(struct renderer *r, const struct params *p,
                         const struct sky_fit *fit, int *seen)
{
    struct buf b = {0};
    double worst = 0;
    renderer_read_linear(r, &b, NULL);
    const float *rgba = (const float *)(const void *)b.data;
    for (int i = 0; i < p->image.width * p->image.height; i += 7) {
        const int pixel[2] = {i % p->image.width, i / p->image.width};
        double n[3], want[3];
        if (rgba[4 * i + 3] > 0 || !normal_at(p, pixel, 9, n))
            continue;
        head_light(fit, p, n, want);
        worst = fmax(worst, error_at(r, p, pixel, want));
        ++*seen;
    }
    buf_finish(&b);
    return worst;
}

static void head(void)
{
    struct params p;
    struct sky_fit fit;
    struct error err = {0};
    int seen = 0;
    base(&p);
    p.view.exposure = 2;
    check_case("the head's light is the double's");
    struct sky_map *map = scene_two_lamps();
    CHECK(sky_fit_run(map, p.sky.lights, (enum sky_fit_mode)p.sky.fit, NULL,
                      &fit, &err));
    struct renderer *r = scene_renderer(scene_lock(1, 6), map, &p);
    scene_finish(r);
    CHECK_ATMOST(head_error(r, &p, &fit, &seen), STEP);
    CHECK(seen > 20);
    check_case("... and of a tinted sky");
    p.tint.exposure = -1;
    p.tint.colour[1] = 0.3f;
    p.tint.colour[2] = 0;
    renderer_set_params(r, &p);
    CHECK_ATMOST(head_error(r, &p, &fit, &seen), STEP);
    renderer_destroy(r);
}

static void sky(void)
{
    struct params p;
    const int corner[2] = {3, 5};
    base(&p);
    p.view.background = 2;
    check_case("a constant sky stands behind, in its tint");
    struct renderer *r =
        scene_renderer(scene_lock(1, 6), scene_constant_sky(0.25f), &p);
    scene_finish(r);
    for (int k = 0; k < 3; k++) {
        p.tint.exposure = (float)k - 1;
        p.tint.colour[0] = 0.8f;
        p.tint.colour[2] = 0.1f * (float)k;
        double want[3];
        for (int c = 0; c < 3; c++)
            want[c] = 0.25 * exp2(p.tint.exposure) * (double)p.tint.colour[c];
        renderer_set_params(r, &p);
        CHECK_ATMOST(error_at(r, &p, corner, want), STEP);
    }
    renderer_destroy(r);
}

// A sky brighter than a half holds, and hair in it that comes to 1e21 before
// the tone curve, whose square no float holds.
static void brightest(void)
{
    struct params p;
    base(&p);
    p.view.background = 2;
    struct renderer *r =
        scene_renderer(scene_lock(1, 6), scene_constant_sky(1e8f), &p);
    scene_finish(r);
    for (int k = 0; k < 4; k++) {
        int darkest = 255;
        check_case(k < 2 ? "a sky beyond halves is white"
                         : "the brightest that may be asked for is white");
        p.view.curve = k % 2;
        p.tint.exposure = p.view.exposure = k < 2 ? 0 : 20;
        for (int c = 0; c < 3; c++)
            p.tint.colour[c] = k < 2 ? 1 : 100;
        renderer_set_params(r, &p);
        struct buf b = scene_display(r);
        for (size_t i = 0; i < b.size; i++)
            darkest = b.data[i] < darkest ? b.data[i] : darkest;
        CHECK(b.size > 0 && darkest == 255);
        buf_finish(&b);
    }
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    curves();
    head();
    sky();
    brightest();
    return check_end();
}
