// verb_render.c - `glintd render`: one final picture into a file, without any
// socket.  The same state gives the same bytes as a capture of the daemon.
#include "server/verbs.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "renderer/renderer.h"
#include "server/assets.h"
#include "server/cache.h"
#include "server/governor.h"
#include "server/options.h"
#include "server/still.h"
#include "server/verb_reference.h"
#include "server/file.h"

// By the name's end; -1: none that we write.
static int format_of(const char *path)
{
    static const struct {
        const char *end;
        int format;
    } ends[] = {{".jpg", STILL_JPEG},
                {".jpeg", STILL_JPEG},
                {".png", STILL_PNG},
                {".exr", STILL_EXR}};
    size_t n = strlen(path);
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        size_t e = strlen(ends[i].end);
        if (n > e && strcasecmp(path + n - e, ends[i].end) == 0)
            return ends[i].format;
    }
    return -1;
}

struct drawn { // what a governor makes of the parameters
    struct params params;
    char governor[256];
};

// Nothing was measured in this run: it goes by the fronts as they are.
static void govern(struct drawn *d, const struct options *o,
                   const struct governor_state *state)
{
    struct governor g = {0};
    if (!(o->params.quality.budget_ms > 0 || o->params.quality.error > 0))
        return;
    fronts_open(&g.fronts, NULL, NULL);
    governor_resolve(&g, state, &d->params);
    governor_text(&g.note, d->governor, sizeof d->governor);
    governor_finish(&g);
}

static bool open_scene(struct renderer *r, const struct options *o,
                       struct still_state *state, struct drawn *d,
                       struct error *err)
{
    struct assets_hair hair = {0};
    struct assets_sky sky = {0};
    bool ok = assets_hair_load(&hair, o->hair, NULL, err) &&
              assets_sky_load(&sky, o->env, NULL, err);
    if (ok) {
        state->hair = hair.source;
        state->env = sky.source;
        const struct governor_state asked = {
            .params = &o->params,
            .scene = {.device = state->device,
                      .hair = hair.source.sha256,
                      .env = sky.source.sha256,
                      .strands = hair.strands}};
        govern(d, o, &asked);
        renderer_set_params(r, &d->params);
        struct groom *g = hair.groom;
        struct sky_map *m = sky.map;
        hair.groom = NULL;
        sky.map = NULL;
        ok = renderer_set_groom(r, g, err);
        if (ok)
            ok = renderer_set_sky(r, m, err);
        else
            sky_map_destroy(m);
    }
    assets_hair_finish(&hair);
    assets_sky_finish(&sky);
    return ok;
}

static void report(const struct renderer *r, const double *total_ms,
                   const struct still_request *q, size_t bytes)
{
    struct renderer_stats s;
    renderer_stats(r, &s);
    printf("device %s\n", renderer_device(r));
    printf("path %s\n", s.path);
    printf("samples %d, lights %d of %d, first sample shaded points %u\n",
           s.samples, s.lights_used, s.lights_fitted, s.visible_points);
    printf("stage ms of all samples:");
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (total_ms[i] >= 0)
            printf(" %s %.1f", renderer_stage_names[i], total_ms[i]);
    printf("; encode %.1f (%zu bytes)\n", q->encode_ms, bytes);
    for (int i = 0; i < s.left_out_count; i++)
        printf("left out %s: %s (bound %g)\n", s.left_out[i].what,
               s.left_out[i].why, s.left_out[i].bound);
}

static bool refine(struct renderer *r, double *total_ms, struct error *err)
{
    struct renderer_stats s;
    bool done = false;
    for (int i = 0; i < RENDERER_STAGES; i++)
        total_ms[i] = -1;
    while (!done) {
        if (!renderer_step(r, &done, err))
            return false;
        renderer_stats(r, &s);
        for (int i = 0; i < RENDERER_STAGES; i++)
            if (s.stage_ms[i] >= 0)
                total_ms[i] =
                    (total_ms[i] > 0 ? total_ms[i] : 0) + s.stage_ms[i];
    }
    return true;
}

struct wanted {
    int format;
    bool layers, verbose;
};

static int render(const struct options *o, const struct wanted *want)
{
    struct error err = {0};
    struct drawn drawn = {.params = o->params};
    struct still_state state = {.params = &drawn.params};
    struct still_request q = {.state = &state, .with_state = true};
    struct buf out = {0};
    double total_ms[RENDERER_STAGES];
    char *cache = cache_directory();
    struct renderer *r = renderer_create(cache, &err);
    if (r)
        state.device = renderer_device(r);
    bool ok = r && open_scene(r, o, &state, &drawn, &err) &&
              (!want->layers || renderer_layers_on(r, &err)) &&
              refine(r, total_ms, &err);
    if (ok) {
        state.governor = drawn.governor[0] ? drawn.governor : NULL;
        q.how = still_encoding_of(&o->params);
        q.how.format = want->format;
        q.how.layers = want->layers;
        ok = still_encode(&out, r, &q, &err) && file_write(o->out, &out, &err);
    }
    if (ok && want->verbose && state.governor)
        printf("governor %s\n", state.governor);
    if (ok && want->verbose)
        report(r, total_ms, &q, out.size);
    buf_finish(&out);
    renderer_destroy(r);
    free(cache);
    return ok ? 0 : options_fail(&err);
}

static int render_reference(const struct options *o,
                            const struct verb_reference *how)
{
    struct error err = {0};
    struct buf out = {0};
    bool ok = verb_reference_run(o, how, &out, &err) &&
              file_write(o->out, &out, &err);
    buf_finish(&out);
    return ok ? 0 : options_fail(&err);
}

static int usage(const char *what, const char *value, const char *text)
{
    fprintf(stderr, "glintd: render: %s%s: %s\n", what, value, text);
    return 2;
}

// Of either kind, once the command line is read.
static int run(const struct options *o, struct wanted *want,
               const struct verb_reference *how)
{
    const char *method = how->method, *to = o->out ? o->out : "is missing";
    want->format = o->out ? format_of(o->out) : -1;
    if (want->format < 0)
        return usage("--out ", to,
                     "a name that ends in .exr, .png or .jpg is needed");
    if (want->layers && want->format != STILL_EXR)
        return usage("--layers: --out ", to, "only .exr has them");
    if (!method)
        return render(o, want);
    if (strcmp(method, "reference-single") != 0 &&
        strcmp(method, "reference-path") != 0)
        return usage("--method ", method,
                     "is not one of reference-single, reference-path");
    if (want->format != STILL_EXR)
        return usage("--out ", to, "a reference is written as .exr");
    if (want->layers)
        return usage("--layers with --method ", method,
                     "a reference has none but its variance");
    return render_reference(o, how);
}

int verb_render_run(int argc, char **argv)
{
    struct wanted want = {0};
    struct verb_reference how = {.samples = 64};
    const char *fibre = "exact";
    const struct options_row rows[] = {
        {"layers", OPTIONS_FLAG, &want.layers, 0, 0, NULL,
         "write the picture's parts as well: single_R, single_TT, single_TRT, "
         "global, local (.exr)"},
        {"method", OPTIONS_TEXT, &how.method, 0, 0, "NAME",
         "reference-single or reference-path: by rays against the strands, in "
         "double precision (.exr)"},
        {"fibre", OPTIONS_TEXT, &fibre, 0, 0, "exact|marschner",
         "a reference's fibre: exact, or Marschner 2003's practical model"},
        {"spp", OPTIONS_INT, &how.samples, 1, 65536, "N",
         "paths a pixel of a reference; 64 unless given"},
        {"seed", OPTIONS_INT, &how.seed, 0, 2147483647, "N",
         "of a reference's random numbers"},
        {"progress", OPTIONS_FLAG, &how.progress, 0, 0, NULL,
         "tell a reference's progress on stderr, be it a terminal or not"},
        {"verbose", OPTIONS_FLAG, &want.verbose, 0, 0, NULL,
         "print the stages' milliseconds and what was left out"},
        {0}};
    const struct options_verb verb = {
        .name = "render",
        .about = "renders one final picture; the end of FILE's name (.exr .png "
                 ".jpg) tells the format",
        .takes = OPTIONS_SCENE | OPTIONS_OUT,
        .rows = rows,
    };
    struct options o;
    int status = options_parse(&o, &verb, argc, argv);
    how.verbose = want.verbose;
    if (status < 0 && strcmp(fibre, "exact") != 0 &&
        strcmp(fibre, "marschner") != 0)
        status = usage("--fibre ", fibre, "is not one of exact, marschner");
    how.model = strcmp(fibre, "exact") == 0 ? FIBRE_EXACT : FIBRE_MARSCHNER;
    if (status < 0)
        status = run(&o, &want, &how);
    options_finish(&o);
    return status;
}
