// bench_scene.c - opens a scene, has its reference made, then its settings
// measured one after the other.
#include "server/bench_scene.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/renderer.h"
#include "server/assets.h"
#include "server/bench_front.h"

// "straight.hair" and "builtin:studio" become "straight, studio".
static void plain_name(const char *name, char *out, size_t room)
{
    const char *colon = strchr(name, ':');
    snprintf(out, room, "%s", colon ? colon + 1 : name);
    char *dot = strrchr(out, '.');
    if (dot && dot != out)
        *dot = 0;
}

static void name_scene(struct bench_loaded *s, const char *hair,
                       const char *sky)
{
    char a[64], b[64];
    plain_name(hair, a, sizeof a);
    plain_name(sky, b, sizeof b);
    snprintf(s->name, sizeof s->name, "%s%s, %s", a,
             strchr(hair, ':') ? "" : " (file)", b);
    size_t n = 0;
    for (const char *c = s->name; *c && n + 1 < sizeof s->id; c++)
        if (isalnum((unsigned char)*c))
            s->id[n++] = *c;
        else if (n > 0 && s->id[n - 1] != '_')
            s->id[n++] = '_';
    s->id[n] = 0;
}

bool bench_scene_load(struct renderer *r, const char *hair_name,
                      const char *env, const struct params *base,
                      struct bench_loaded *out, struct error *err)
{
    struct assets_hair hair = {0};
    struct assets_sky sky = {0};
    bool ok = assets_hair_load(&hair, hair_name, NULL, err) &&
              assets_sky_load(&sky, env, NULL, err);
    *out =
        (struct bench_loaded){.strands = hair.strands, .points = hair.points};
    renderer_set_params(r, base);
    if (ok) {
        memcpy(out->hair_sha, hair.source.sha256, sizeof out->hair_sha);
        memcpy(out->sky_sha, sky.source.sha256, sizeof out->sky_sha);
        name_scene(out, hair.source.name, sky.source.name);
        struct groom *g = hair.groom;
        struct sky_map *m = sky.map;
        hair.groom = NULL;
        ok = renderer_set_groom(r, g, err);
        if (ok) {
            sky.map = NULL;
            ok = renderer_set_sky(r, m, err);
        }
    }
    assets_hair_finish(&hair);
    assets_sky_finish(&sky);
    return ok;
}

static bool truth(struct bench_scene *s, struct renderer *r,
                  const struct bench_scene_ask *ask, struct error *err)
{
    const struct bench_loaded *l = &s->loaded;
    const struct bench_truth_ask q = {
        .params = ask->base,
        .places = (size_t)ask->places,
        .exact = (size_t)ask->exact,
        .paths = ask->paths,
        .picture_paths = ask->picture_paths,
        .hair_sha = l->hair_sha,
        .sky_sha = l->sky_sha,
        .cache = ask->cache,
    };
    return bench_time_finish(r, ask->base, NULL, err) &&
           bench_truth_make(&s->truth, r, &q, err);
}

static bool measure(struct bench_scene *s, const struct bench_view *v,
                    const struct bench_scene_ask *ask, struct error *err)
{
    struct bench_result *b = &s->result;
    struct bench_choice choice = ask->choice;
    struct buf line = {0};
    bool ok = true;
    s->setting = bytes_zalloc(BENCH_KNOBS_MAX, sizeof *s->setting);
    s->row = bytes_zalloc(BENCH_KNOBS_MAX, sizeof *s->row);
    b->row = s->row;
    const int n = ask->front
                      ? bench_front_list(ask->base, choice.only, s->setting)
                      : bench_knobs_list(ask->base, &choice, s->setting);
    for (int i = 0; ok && i < n; i++) {
        ok = ask->front ? bench_front_row(v, &s->setting[i], &s->row[i], err)
                        : bench_measure_row(v, &s->setting[i], &s->row[i], err);
        if (!ok)
            break;
        b->rows = i + 1;
        buf_clear(&line);
        if (ask->front)
            bench_front_json(b, &s->row[i], &line);
        else
            bench_report_json_row(b, &s->row[i], &line);
        ask->tell(ask->self, &line);
    }
    if (ok && ask->causes && v->truth->exact > 0)
        ok = b->causes = bench_measure_causes(v, b->cause, err);
    for (int i = 0; b->causes && i < BENCH_CAUSES; i++) {
        buf_clear(&line);
        bench_report_json_cause(b, &b->cause[i], &line);
        ask->tell(ask->self, &line);
    }
    buf_finish(&line);
    return ok;
}

bool bench_scene_run(struct bench_scene *s, const struct bench_scene_ask *ask,
                     struct error *err)
{
    struct buf line = {0};
    *s = (struct bench_scene){0};
    struct bench_result *b = &s->result;
    struct renderer *r = renderer_create(ask->cache, err);
    struct bench_loaded *l = &s->loaded;
    bool ok = r &&
              bench_scene_load(r, ask->hair, ask->env, ask->base, l, err) &&
              truth(s, r, ask, err);
    if (ok) {
        snprintf(s->device, sizeof s->device, "%s", renderer_device(r));
        b->name = l->name;
        b->id = l->id;
        b->strands = l->strands;
        b->points = l->points;
        b->device = s->device;
        b->truth = &s->truth;
        b->paths = ask->paths;
        b->picture_paths = ask->picture_paths;
        b->picture_samples = ask->picture_samples;
        const struct bench_view v = {
            .name = l->name,
            .r = r,
            .base = ask->base,
            .truth = &s->truth,
            .effort = ask->effort,
            .picture_samples = ask->picture_samples,
        };
        bench_report_json_scene(b, &line);
        ask->tell(ask->self, &line);
        ok = measure(s, &v, ask, err);
    }
    buf_finish(&line);
    renderer_destroy(r);
    return ok;
}

void bench_scene_finish(struct bench_scene *s)
{
    bench_truth_finish(&s->truth);
    free(s->setting);
    free(s->row);
    *s = (struct bench_scene){0};
}
