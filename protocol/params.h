// params.h - the parameters as plain values, and the table that describes them.
//
// `struct params` is plain data: assigning it is an edit, a copy is an undo.
// A value that is `auto` is NaN (in its first component for a vector); who
// reads such a value resolves it (params_fibre_resolve; camera: the renderer).
// Thread: any (constants and values only).
#ifndef PROTOCOL_PARAMS_H
#define PROTOCOL_PARAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GROUP(g, title) struct {
#define FLOAT(g, n, def, lo, hi, unit, doc) float n;
#define AUTO(g, n, lo, hi, unit, doc) float n;
#define INT(g, n, def, lo, hi, unit, doc) int32_t n;
#define BOOL(g, n, def, doc) int32_t n;
#define CHOICE(g, n, def, words, doc) int32_t n;
#define RGB(g, n, r, gr, b, lo, hi, unit, doc) float n[3];
#define VEC3(g, n, lo, hi, unit, doc) float n[3];
// clang-format off
#define END(g) } g;
// clang-format on
struct params {
#include "protocol/params.def"
};
#undef GROUP
#undef FLOAT
#undef AUTO
#undef INT
#undef BOOL
#undef CHOICE
#undef RGB
#undef VEC3
#undef END

// GROUP_hair, GROUP_fibre, ... in table order; PARAMS_GROUPS of them.
#define GROUP(g, title) GROUP_##g,
#define FLOAT(g, n, def, lo, hi, unit, doc)
#define AUTO(g, n, lo, hi, unit, doc)
#define INT(g, n, def, lo, hi, unit, doc)
#define BOOL(g, n, def, doc)
#define CHOICE(g, n, def, words, doc)
#define RGB(g, n, r, gr, b, lo, hi, unit, doc)
#define VEC3(g, n, lo, hi, unit, doc)
#define END(g)
enum params_group {
#include "protocol/params.def"
    PARAMS_GROUPS
};
#undef GROUP
#undef FLOAT
#undef AUTO
#undef INT
#undef BOOL
#undef CHOICE
#undef RGB
#undef VEC3
#undef END

enum params_type {
    PARAMS_FLOAT,
    PARAMS_INT,
    PARAMS_BOOL,
    PARAMS_CHOICE,
    PARAMS_RGB, // 3 floats
    PARAMS_VEC3 // 3 floats
};

struct params_row {
    enum params_group group;
    const char *group_name; // "fibre"
    const char *name;       // "eta"; on the wire "fibre.eta"
    enum params_type type;
    bool has_auto; // `auto` is a legal value, and the default
    double def[3]; // in the unit below; choices: index
    double min, max;
    const char *unit;    // "" where none
    const char *choices; // "word|word|..." of a PARAMS_CHOICE, else NULL
    const char *doc;
    size_t offset; // into struct params, of the first component
    int count;     // components: 1 or 3
};

extern const struct params_row params_rows[];
extern const int params_row_count;
extern const char *const params_group_names[PARAMS_GROUPS];
extern const char *const params_group_titles[PARAMS_GROUPS];

// Every parameter at its default.
void params_defaults(struct params *p);

// The row of "group.name", or NULL.
const struct params_row *params_find(const char *name, size_t length);

// What the parameter needs to move the picture, as NEEDS in params.def has it:
// "render.scheme=paper or render.multiple=paper|best"; NULL: nothing.
const char *params_needs(const struct params_row *row);

// Component i (0..count-1) as a double; NaN when the value is `auto`.
double params_get(const struct params *p, const struct params_row *row, int i);
// Stores without checking; integers are rounded.
void params_put(struct params *p, const struct params_row *row, int i,
                double value);

// Bit g is set when group g differs between the two, NaN equal to NaN.
uint32_t params_changed(const struct params *a, const struct params *b);

// Fills the linked fibre parameters that are `auto` (Xu 2011, section 6:
// alpha_TT = -alpha_R/2, alpha_TRT = -3/2 alpha_R, beta_TT = beta_R/2,
// beta_TRT = 2 beta_R).  Still in degrees; results are not clipped to the rows'
// ranges except beta, whose floor 0.1 deg holds for a linked value too.
void params_fibre_resolve(struct params *p);

#endif
