// front.h - fronts: what settings of the knobs cost, and how wrong they are, as
// `glintd bench --front` measured them.  One front is one scene on one machine.
//
// As text, one line each (the grammar of protocol/line.h):
//
//   front device=TEXT cores=N scene=TEXT hair=SHA env=SHA strands=N
//   row [KNOB=VALUE ...] fibre_ms=X sky_ms=X camera_ms=X rest_ms=X error=X
//
// The first line is `glint.front 1`; a `#` begins a line that is not read.  A
// knob that a row does not name is at its default.
// Thread: any; an object belongs to one thread at a time.
#ifndef SERVER_FRONT_H
#define SERVER_FRONT_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/params.h"

enum { FRONT_ROWS_MAX = 128, FRONT_MAX = 64, FRONT_BYTES_MAX = 1 << 20 };

enum front_edit {
    FRONT_FIBRE, // fibre.sigma_a
    FRONT_SKY,   // light.yaw
    FRONT_CAMERA // camera.fov
};
enum { FRONT_EDITS = 3 };

// In the order of front_knob_names: what a front's rows differ in.
enum front_knob {
    FRONT_LIGHTS,
    FRONT_LIGHT_BOUND,
    FRONT_RESOLUTION,
    FRONT_DIRECTIONS,
    FRONT_RAYS
};
enum { FRONT_KNOBS = 5 };
extern const char *const front_knob_names[FRONT_KNOBS]; // as `set` takes them

extern const char *const front_time_names[FRONT_EDITS]; // in a file

struct front_row {
    double knob[FRONT_KNOBS]; // choices: index
    // ms from an edit to the first full frame, whose shadows are the field's
    double first_ms[FRONT_EDITS];
    double rest_ms; // from a fibre edit to the first sample with its rays, if
                    // the row has any
    double error;   // of that picture: relative RMSE at visible places
};

struct front {
    char device[160], scene[136];
    char hair[65], env[65]; // SHA-256, hexadecimal
    int cores;
    uint32_t strands;
    bool shipped;
    int rows; // >= 1
    struct front_row row[FRONT_ROWS_MAX];
};

struct fronts { // zero-initialised is empty
    struct front *item;
    int count;
};

// Adds those in a text, all or none.  `name` is what errors call it.  Code
// "front" for what is not as above, with the line's number; "limit".
bool fronts_parse(struct fronts *f, struct span text, const char *name,
                  struct error *err);
bool fronts_load(struct fronts *f, const char *path, struct error *err);
void fronts_shipped(struct fronts *f); // adds those of server/front.txt
// Both: path's, or where that is NULL the cache directory's front.txt, which
// may be missing or bad (then it is logged), then what ships.
bool fronts_open(struct fronts *f, const char *path, struct error *err);
// That file; the caller frees it.  NULL: there is no cache directory.
char *front_cache_path(void);
void fronts_finish(struct fronts *f);

struct front_scene { // what a front is looked for
    const char *device, *hair, *env;
    uint32_t strands;
};
// The front of the scene most like it: the same hair or, else, about as many
// strands; then the same sky; then the same device; then the first.  NULL when
// there are none.
const struct front *fronts_nearest(const struct fronts *f,
                                   const struct front_scene *scene);

// Appends one front with its rows.
void front_print(const struct front *f, struct buf *out);
extern const char front_magic[]; // the first line of a file, with its end

double front_knob(const struct params *p, int knob);
double front_knob_default(int knob);
void front_put(struct params *p, int knob, double value);
// Appends "sky.lights=20 shadow.rays=0": those of `knob` that are not what
// `from` has; nothing where there are none.
void front_print_knobs(struct buf *out, const double knob[FRONT_KNOBS],
                       const double from[FRONT_KNOBS]);

#endif
