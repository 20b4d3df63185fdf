// bench_kinds.h - the edits that `glintd bench --edits` times: one table of
// kinds, each with what it changes and what it is to take.
// Thread: any (no state).
#ifndef SERVER_BENCH_KINDS_H
#define SERVER_BENCH_KINDS_H

#include <stdbool.h>

#include "protocol/params.h"
#include "server/bench_time.h"

enum bench_way {    // how a kind is measured
    BENCH_WAY_EDIT, // edits until the picture is done
    BENCH_WAY_DRAG, // frames of a drag, drafts where they are needed
    BENCH_WAY_COLD, // a daemon from its start to the first frame
};

enum {
    BENCH_KINDS_SCENES = 3,
    BENCH_KINDS_MOVED = 1, // judged at an edited state: light or view is
                           // another
    BENCH_KINDS_LONG = 2,  // takes so long that runs may be fewer
    BENCH_KINDS_CHIEF = 4  // in the short table
};

struct bench_kind {
    const char *name;    // "light colour"
    const char *with;    // assignments for the whole row, or ""
    bench_edit_fn *edit; // self: struct bench_kinds_scene
    enum bench_way way;
    int forward; // the edit of bench_edit_names that paper-forward is timed
                 // with to compare, -1: none
    unsigned flags;
    // ms; NaN: none.  For animation, straight, natural (the curly one).
    double target[BENCH_KINDS_SCENES];
};

struct bench_kinds_scene {
    float eye[3], target[3]; // in use, world
};

// The kinds of a whole scene; *count of them.
const struct bench_kind *bench_kinds(int *count);
// Those of a scene that stands for hair that is bent, from a file.
const struct bench_kind *bench_kinds_file(int *count);
// Of which of the three scenes the targets are ("animation"); -1: none.
int bench_kinds_scene(const char *hair);

// Every fibre parameter that moves a picture of a circular fibre, in an order
// that is random and always the same.
extern const char *const bench_kinds_fibre[];
enum { BENCH_KINDS_FIBRE = 12 };
// Which of them edit number k is of.
int bench_kinds_fibre_at(int k);
bench_edit_fn bench_kinds_any_fibre;

// Xu 2011, Table 2.
struct bench_paper_scene {
    const char *hair; // the built-in groom that stands for it
    int lights;
    double fps; // on a GTX 580, 720 x 480
};
extern const struct bench_paper_scene bench_kinds_paper[6];
const struct bench_paper_scene *bench_kinds_paper_of(const char *hair);

#endif
