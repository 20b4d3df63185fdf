// bench_knobs.h - the settings that `glintd bench` compares: one table of
// knobs, each with values that it takes while everything else stays.
// Thread: any (no state).
#ifndef SERVER_BENCH_KNOBS_H
#define SERVER_BENCH_KNOBS_H

#include <stdbool.h>

#include "protocol/params.h"

enum {
    BENCH_KNOBS_MAX = 96,
    BENCH_KNOBS_QUICK = 1,    // part of a short run
    BENCH_KNOBS_INTEGRAL = 2, // bears upon how one light is integrated
    BENCH_KNOBS_SKY = 4,      // a turn of the sky is timed too
    BENCH_KNOBS_PICTURE = 8,  // of pictures alone: says nothing about a place
    BENCH_KNOBS_DEAR = 16,    // takes long: only in a run's first scene
};

struct bench_setting {
    char method[40]; // "paper", "paper-forward": render.scheme and .path
    const char *group;
    char text[120]; // what differs from the base, as `set` takes it, or
                    // "default"
    struct params params;
    unsigned flags;
};

struct bench_choice {
    bool quick, first; // a short run; the run's first scene
    const char *only;  // words, joined by commas; settings whose group or
                       // text holds one of them, and the default.  NULL: all
    unsigned left_out; // out: rows that this program does not know
};

// Fills out[BENCH_KNOBS_MAX]; returns how many.  The first is the base itself.
// A value that the parameter table does not know is left out and counted, one
// that makes what an earlier row made is not repeated.
int bench_knobs_list(const struct params *base, struct bench_choice *choice,
                     struct bench_setting *out);

// Does `only` (as above) let it in?
bool bench_knobs_wanted(const struct bench_setting *s, const char *only);

bool bench_knobs_forward(const struct params *p); // render.path is forward

// Groups in the order of the table, NULL-terminated; number of one.
extern const char *const bench_knobs_groups[];
int bench_knobs_group(const char *name);

#endif
