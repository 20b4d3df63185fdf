// verb_reference.c - opens a scene for the references, shows their progress,
// encodes the result.  What is computed is renderer/reference.h's.
#include "server/verb_reference.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "renderer/encode.h"
#include "renderer/reference.h"
#include "server/assets.h"
#include "server/clock.h"
#include "server/still.h"

struct teller {
    const char *method;
    int samples;
    bool terminal;
    int64_t last_us; // of the last line; 0: none
};

static bool tell(void *self, const struct reference_progress *p)
{
    struct teller *t = self;
    const int64_t now = clock_us(), apart = t->terminal ? 100000 : 1000000;
    const bool done = p->samples >= t->samples;
    if (!done && t->last_us && now - t->last_us < apart)
        return true;
    t->last_us = now;
    fprintf(stderr, "%s%s: %d of %d samples, %.0f s left%s",
            t->terminal ? "\r" : "", t->method, p->samples, t->samples,
            p->seconds_left, t->terminal ? "\033[K" : "\n");
    if (t->terminal && done)
        fputc('\n', stderr);
    return true;
}

static struct reference *open_scene(const struct options *o,
                                    enum fibre_model model,
                                    struct still_state *state,
                                    struct error *err)
{
    struct assets_hair hair = {0};
    struct assets_sky sky = {0};
    struct reference *s = NULL;
    if (assets_hair_load(&hair, o->hair, NULL, err) &&
        assets_sky_load(&sky, o->env, NULL, err)) {
        const struct reference_scene scene = {hair.groom, sky.map, NULL,
                                              &o->params, model,   NULL};
        state->hair = hair.source;
        state->env = sky.source;
        s = reference_create(&scene, err);
    }
    assets_hair_finish(&hair);
    assets_sky_finish(&sky);
    return s;
}

static bool draw(const struct reference *s, const struct options *o,
                 const struct verb_reference *how, float *pixels,
                 struct error *err)
{
    struct teller teller = {how->method, how->samples,
                            isatty(STDERR_FILENO) == 1, 0};
    const size_t n =
        4 * (size_t)o->params.image.width * (size_t)o->params.image.height;
    const struct reference_paths paths = {
        .samples = how->samples,
        .events = strcmp(how->method, "reference-single") == 0,
        .seed = (uint64_t)how->seed,
        .progress = teller.terminal || how->progress ? tell : NULL,
        .self = &teller,
    };
    int made;
    const int64_t began = clock_us();
    if (!reference_picture(s, &paths, pixels, pixels + n, &made, err))
        return false;
    if (how->verbose)
        printf("%s: %d samples of %d x %d in %.2f s\n", how->method, made,
               o->params.image.width, o->params.image.height,
               (double)(clock_us() - began) / 1e6);
    return true;
}

bool verb_reference_run(const struct options *o,
                        const struct verb_reference *how, struct buf *out,
                        struct error *err)
{
    char device[96];
    snprintf(device, sizeof device, "%s, %s fibre, %d samples, seed %d",
             how->method, how->model == FIBRE_EXACT ? "exact" : "marschner",
             how->samples, how->seed);
    struct still_state state = {.params = &o->params, .device = device};
    if (!reference_picture_fits(&o->params, how->samples, err))
        return false; // before anything is loaded
    struct reference *s = open_scene(o, how->model, &state, err);
    if (!s)
        return false;
    const size_t n =
        4 * (size_t)o->params.image.width * (size_t)o->params.image.height;
    float *pixels = bytes_alloc(2 * n * sizeof *pixels);
    bool ok = draw(s, o, how, pixels, err);
    if (ok) {
        const struct encode_layer layers[] = {{"", pixels, true},
                                              {"variance", pixels + n, true}};
        ok = still_encode_layers(out, &state, layers, 2, err);
    }
    free(pixels);
    reference_destroy(s);
    return ok;
}
