// lit_tables.h - what each light does to a fibre, all modes added up, as tables
// of local quadratics that are made once an edit of the fibre (shaders/lit*):
// a place then costs a light two cells instead of nine.  Made from the tables
// of fast_tables.h, which hold for every light, at the middles of cells.
//
// A light's table: M_R + M_TT + M_TRT and its glow (Xu 2011, eq 11, 29, 30)
// over s = theta_o + theta_j, theta_o and |Phi|; as fine as light and lobes
// together are narrow.  The far table: M^G + d_b M^L (eq 27, 29) over the same
// and ln sigma_f, for all lights.
//
// A light's table is made where places read it: their cells are marked once for
// each view, and edits of the fibre make those alone.  What a cell holds
// depends on fibre and light only, so it does not matter who asked for it.
#ifndef RENDERER_LIT_TABLES_H
#define RENDERER_LIT_TABLES_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/light_groups.h"
#include "renderer/lights.h"
#include "renderer/lit_plan.h"

enum {
    LIT_TABLES_UNIT = 21,  // as shaders/lit.glsl declares them
    LIT_TABLES_BINDING = 9 // uniform block
};

// The largest error that was measured of a place against direct evaluation, a
// twentieth of the picture's mean added to what it is of: of 20,000 of
// `animation` and `natural` each under the studio, lobes of 7.5 and 3 degrees.
#define LIT_TABLES_ERROR 0.15

struct lit_tables;

// Thread: any, one at a time; no GL is called.
struct lit_tables *lit_tables_create(void);

// From now on the tables are of this fibre.
void lit_tables_fibre(struct lit_tables *t, const struct lit_fibre *f);

// Thread: render, from here on.
// Their tables' shape by `of`, the rest from `l`, whose order `of` has.  False
// when there is no memory for the buffers.
bool lit_tables_lights(struct lit_tables *t, const struct lit_lights *of,
                       const struct lights *l, struct error *err);

// How many tables there are, and which lights have none (lit_plan.h).
const struct lit_plan *lit_tables_plan(const struct lit_tables *t);
// Which lights are one for what other fibres scatter forward.
const struct light_groups *lit_tables_groups(const struct lit_tables *t);

// What places read has changed: marks and records are to be made anew.
void lit_tables_forget(struct lit_tables *t);
// Are there marks of what is to be shaded, and records, if any, in the order
// that goes by this number?  Are there records?  (They outlive another size of
// cells.)
bool lit_tables_marked(const struct lit_tables *t, unsigned made);
bool lit_tables_recorded(const struct lit_tables *t, unsigned made);
// If neither: makes room for records of so many places and sorts them (0, or
// too many for a buffer: none are kept; the cells of the picture's first part,
// lights and transmittances are bound), then clears the marks and binds what
// `program` needs, which marks and makes records (shaders/lit_mark.comp).
bool lit_tables_keep(struct lit_tables *t, uint32_t places, struct error *err);
void lit_tables_mark(struct lit_tables *t, unsigned program, unsigned made);
// How many places have records; `program` will read them.
uint32_t lit_tables_kept(const struct lit_tables *t);
void lit_tables_read(const struct lit_tables *t, unsigned program);

// Makes what is wanted and is not there yet, marked cells or all, and binds
// unit and block.  Bound are: parameter and light blocks, fast_tables and, with
// multiple scattering, dual_tables.  Storage buffers 12 and 15 and units 22 and
// 23 are used.
bool lit_tables_make(struct lit_tables *t, bool all, struct error *err);

uint64_t lit_tables_bytes(const struct lit_tables *t); // on the device
// NULL is allowed.
void lit_tables_destroy(struct lit_tables *t);

#endif
