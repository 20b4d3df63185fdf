// verb_fit.c - `glintd fit`: the lights that stand for a sky, as text or JSON,
// and as pictures of the sky, of the lights and of what lies between them.
#include "server/verbs.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/digest.h"
#include "protocol/json.h"
#include "renderer/encode.h"
#include "renderer/sky.h"
#include "server/cache.h"
#include "server/options.h"
#include "server/file.h"

static const double pi = 3.14159265358979323846;

enum { PICTURE_WIDTH = 1024 }; // at most; lobes hold no finer detail

struct fit {
    struct options options;
    int lights;
    const char *mode; // word of sky.fit
    double target;    // > 0: grow the number of lights until it is met
    bool json, no_cache;
    enum sky_fit_mode kind;
    struct sky_map *map;
    struct sky_fit result;
};

// Wrong usage is told here; the result is whether to go on.
static bool check_usage(struct fit *f)
{
    f->kind = (enum sky_fit_mode)f->options.params.sky.fit;
    if (f->target > 0 && f->lights > 0) {
        fprintf(stderr, "glintd: fit: --target and --lights exclude each "
                        "other\n");
        return false;
    }
    if (f->mode && strcmp(f->mode, "hair") == 0)
        f->kind = SKY_FIT_HAIR;
    else if (f->mode && strcmp(f->mode, "plain") == 0)
        f->kind = SKY_FIT_PLAIN;
    else if (f->mode) {
        fprintf(stderr, "glintd: fit: --mode: '%s' is not one of hair, plain\n",
                f->mode);
        return false;
    }
    return true;
}

// With a target, the first of these numbers whose foretold error keeps it with
// a third to spare (the residual tells the error within a factor 1.5).
static bool run(struct fit *f, struct error *err)
{
    static const int ladder[] = {10, 14, 20, 28, 40, 56, 80, 112, 160, 200};
    char *cache = f->no_cache ? NULL : cache_directory();
    bool ok = true;
    if (f->target > 0)
        for (size_t i = 0; ok && i < sizeof ladder / sizeof ladder[0]; i++) {
            ok =
                sky_fit_run(f->map, ladder[i], f->kind, cache, &f->result, err);
            if (1.3 / 0.85 * f->result.predicted_error <= f->target)
                break;
        }
    else
        ok = sky_fit_run(f->map,
                         f->lights ? f->lights : f->options.params.sky.lights,
                         f->kind, cache, &f->result, err);
    free(cache);
    return ok;
}

// --- report ----------------------------------------------------------------

static void angles(const double d[3], double *theta, double *phi)
{
    *theta = asin(fmax(-1, fmin(1, d[2]))) * 180 / pi;
    *phi = atan2(d[1], d[0]) * 180 / pi;
}

static void print_lights(const struct sky_fit *r)
{
    printf("%4s %8s %8s %9s %12s %12s %12s %7s\n", "#", "elev", "azim",
           "lambda", "red", "green", "blue", "share");
    double total = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < r->count; j++) {
            const struct sky_light *l = &r->light[j];
            double theta, phi,
                e = sky_lobe_omega(l->lambda) *
                    (l->radiance[0] + l->radiance[1] + l->radiance[2]);
            if (pass == 0) {
                total += e;
                continue;
            }
            angles(l->direction, &theta, &phi);
            printf("%4d %8.3f %8.3f %9.5f %12.6g %12.6g %12.6g %6.2f%%\n",
                   j + 1, theta, phi, l->lambda, l->radiance[0], l->radiance[1],
                   l->radiance[2], 100 * e / total);
        }
}

static void print_text(const struct fit *f)
{
    const struct sky_fit *r = &f->result;
    const struct sky_cleaned *c = &f->map->cleaned;
    printf("sky %s, %d x %d\n", f->map->name, f->map->width, f->map->height);
    if (f->map->width != 2 * f->map->height)
        printf("note: not 2:1; taken as a lat-long map all the same\n");
    printf("cleaned %llu negative, %llu nan, %llu infinite: %.3g of the "
           "energy\n",
           (unsigned long long)c->negative, (unsigned long long)c->nan,
           (unsigned long long)c->infinite, c->energy_share);
    printf("mode %s, lights %d, residual %.5f, shading error to expect %.4f "
           "(p90)\n",
           f->kind == SKY_FIT_HAIR ? "hair" : "plain", r->count, r->residual,
           r->predicted_error);
    printf("energy of lights over map before scaling %.5f %.5f %.5f\n",
           r->energy_ratio[0], r->energy_ratio[1], r->energy_ratio[2]);
    printf("%.3f s, %d iterations%s\n", r->seconds, r->iterations,
           r->from_cache ? " (kept from an earlier fit)" : "");
    print_lights(r);
}

static void put_triple(struct json *j, const char *key, const double v[3])
{
    json_key(j, key);
    json_open_array(j);
    for (int k = 0; k < 3; k++)
        json_number(j, v[k]);
    json_close_array(j);
}

static void json_lights(struct json *j, const struct sky_fit *r)
{
    json_key(j, "lights");
    json_open_array(j);
    for (int i = 0; i < r->count; i++) {
        json_open_object(j);
        put_triple(j, "direction", r->light[i].direction);
        json_put_number(j, "lambda", r->light[i].lambda);
        put_triple(j, "radiance", r->light[i].radiance);
        json_close_object(j);
    }
    json_close_array(j);
}

static void print_json(const struct fit *f)
{
    struct buf out = {0};
    struct json j = json_begin(&out);
    const struct sky_fit *r = &f->result;
    const struct sky_cleaned *c = &f->map->cleaned;
    char hex[65];
    digest_hex(f->map->sha256, sizeof f->map->sha256, hex);
    json_open_object(&j);
    json_put_string(&j, "sky", f->map->name);
    json_put_string(&j, "sha256", hex);
    json_put_int(&j, "width", f->map->width);
    json_put_int(&j, "height", f->map->height);
    json_key(&j, "cleaned");
    json_open_object(&j);
    json_put_int(&j, "negative", (int64_t)c->negative);
    json_put_int(&j, "nan", (int64_t)c->nan);
    json_put_int(&j, "infinite", (int64_t)c->infinite);
    json_put_number(&j, "energy_share", c->energy_share);
    json_close_object(&j);
    json_put_string(&j, "mode", f->kind == SKY_FIT_HAIR ? "hair" : "plain");
    json_put_number(&j, "residual", r->residual);
    json_put_number(&j, "predicted_error", r->predicted_error);
    put_triple(&j, "energy_ratio", r->energy_ratio);
    json_put_number(&j, "seconds", r->seconds);
    json_put_int(&j, "iterations", r->iterations);
    json_put_bool(&j, "from_cache", r->from_cache);
    json_lights(&j, r);
    json_close_object(&j);
    buf_byte(&out, '\n');
    fwrite(out.data, 1, out.size, stdout);
    buf_finish(&out);
}

// --- pictures --------------------------------------------------------------

struct pictures {
    int width, height;
    float *map, *lights, *residual; // RGBA
};

// Mean of the map's pixels that fall into one of the picture.
static void sample_map(const struct sky_map *m, const struct pictures *p, int x,
                       int y, double rgb[3])
{
    int x0 = (int)((int64_t)x * m->width / p->width);
    int x1 = (int)((int64_t)(x + 1) * m->width / p->width);
    int y0 = (int)((int64_t)y * m->height / p->height);
    int y1 = (int)((int64_t)(y + 1) * m->height / p->height);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int j = y0; j < y1; j++)
        for (int i = x0; i < x1; i++) {
            const float *from =
                m->rgb + 3 * ((size_t)j * (size_t)m->width + (size_t)i);
            for (int k = 0; k < 3; k++)
                rgb[k] += (double)from[k] / ((y1 - y0) * (x1 - x0));
        }
}

static void make_pictures(const struct fit *f, struct pictures *p)
{
    const struct sky_map *m = f->map;
    p->width = m->width < PICTURE_WIDTH ? m->width : PICTURE_WIDTH;
    p->height = (int)((int64_t)p->width * m->height / m->width);
    p->height = p->height > 0 ? p->height : 1;
    size_t size = (size_t)p->width * (size_t)p->height * 4;
    p->map = bytes_alloc(size * sizeof(float));
    p->lights = bytes_alloc(size * sizeof(float));
    p->residual = bytes_alloc(size * sizeof(float));
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            double theta = pi * (0.5 - (y + 0.5) / p->height);
            double phi = pi * (1 - 2 * (x + 0.5) / p->width);
            double d[3] = {cos(theta) * cos(phi), cos(theta) * sin(phi),
                           sin(theta)};
            double map[3], lights[3];
            sample_map(m, p, x, y, map);
            sky_fit_eval(&f->result, d, lights);
            size_t at = 4 * ((size_t)y * (size_t)p->width + (size_t)x);
            for (int k = 0; k < 3; k++) {
                p->map[at + (size_t)k] = (float)map[k];
                p->lights[at + (size_t)k] = (float)lights[k];
                p->residual[at + (size_t)k] = (float)(map[k] - lights[k]);
            }
            p->map[at + 3] = p->lights[at + 3] = p->residual[at + 3] = 1;
        }
}

static bool write_picture(const struct fit *f, const struct pictures *p,
                          const char *what, const float *rgba,
                          struct error *err)
{
    char path[4200], hex[65], residual[32];
    snprintf(path, sizeof path, "%s_%s.exr", f->options.out, what);
    snprintf(residual, sizeof residual, "%.6g", f->result.residual);
    digest_hex(f->map->sha256, sizeof f->map->sha256, hex);
    const struct encode_layer layer = {"", rgba, false};
    const char *const text[] = {"sky",
                                f->map->name,
                                "sky.sha256",
                                hex,
                                "sky.fit",
                                f->kind == SKY_FIT_HAIR ? "hair" : "plain",
                                "sky.residual",
                                residual,
                                NULL};
    const struct encode_exr picture = {p->width, p->height, false,
                                       &layer,   1,         text};
    struct buf bytes = {0};
    bool ok =
        encode_exr(&bytes, &picture, err) && file_write(path, &bytes, err);
    buf_finish(&bytes);
    return ok;
}

static bool write_pictures(const struct fit *f, struct error *err)
{
    struct pictures p;
    make_pictures(f, &p);
    bool ok = write_picture(f, &p, "map", p.map, err) &&
              write_picture(f, &p, "lights", p.lights, err) &&
              write_picture(f, &p, "residual", p.residual, err);
    free(p.map);
    free(p.lights);
    free(p.residual);
    return ok;
}

static bool fit(struct fit *f, struct error *err)
{
    f->map = sky_open(f->options.env, err);
    if (!f->map || !run(f, err))
        return false;
    if (f->json)
        print_json(f);
    else
        print_text(f);
    return !f->options.out || write_pictures(f, err);
}

int verb_fit_run(int argc, char **argv)
{
    struct fit *f = bytes_zalloc(1, sizeof *f);
    const struct options_row rows[] = {
        {"lights", OPTIONS_INT, &f->lights, 1, SKY_LIGHTS_MAX, "N",
         "how many lights; short for --set sky.lights=N"},
        {"mode", OPTIONS_TEXT, &f->mode, 0, 0, "hair|plain",
         "what the fit preserves; short for --set sky.fit=..."},
        {"target", OPTIONS_REAL, &f->target, 1e-3, 1, "ERROR",
         "instead: as many lights as a shading error (p90) needs"},
        {"json", OPTIONS_FLAG, &f->json, 0, 0, NULL, "print JSON"},
        {"no-cache", OPTIONS_FLAG, &f->no_cache, 0, 0, NULL,
         "neither use nor keep fits on disk"},
        {0}};
    const struct options_verb verb = {
        .name = "fit",
        .about = "fits SRBF lights to a sky; --out PREFIX writes "
                 "PREFIX_map.exr, _lights.exr and _residual.exr",
        .takes = OPTIONS_ENV | OPTIONS_SET | OPTIONS_OUT,
        .rows = rows,
    };
    struct error err = {0};
    int status = options_parse(&f->options, &verb, argc, argv);
    if (status < 0 && !check_usage(f))
        status = 2;
    if (status < 0)
        status = fit(f, &err) ? 0 : options_fail(&err);
    options_finish(&f->options);
    sky_map_destroy(f->map);
    free(f);
    return status;
}
