// bench_scene.h - one scene from its name to its results.
// Thread: main, which is the renderer's here.
#ifndef SERVER_BENCH_SCENE_H
#define SERVER_BENCH_SCENE_H

#include <stdbool.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "server/bench_knobs.h"
#include "server/bench_report.h"

struct bench_scene_ask {
    const char *hair, *env; // as options have them
    const struct params *base;
    struct bench_choice choice;
    struct bench_effort effort;
    int places, exact, paths, picture_paths, picture_samples;
    const char *cache; // directory, or NULL
    bool causes;
    bool front; // the settings of a front, and no more of them than it needs
    // Called with each result as it comes; one line of JSON in *line.
    void (*tell)(void *self, const struct buf *line);
    void *self;
};

struct bench_loaded {        // what was opened
    char name[136], id[136]; // "ponytail, studio"; letters, digits, '_'
    char hair_sha[65], sky_sha[65];
    uint32_t strands, points;
};
// Gives the renderer a groom and a sky, as options name them.
bool bench_scene_load(struct renderer *r, const char *hair, const char *env,
                      const struct params *base, struct bench_loaded *out,
                      struct error *err);

struct bench_scene { // zero-initialised is empty
    struct bench_result result;
    struct bench_loaded loaded;
    char device[160];
    struct bench_truth truth;
    struct bench_setting *setting;
    struct bench_row *row;
};

bool bench_scene_run(struct bench_scene *s, const struct bench_scene_ask *ask,
                     struct error *err);
void bench_scene_finish(struct bench_scene *s);

#endif
