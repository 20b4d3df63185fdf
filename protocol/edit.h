// edit.h - parameters as text: set, get, and the errors of both.
//
// A value is what its row's type says: a number; a whole number; on/off, true/
// false, 1/0; a word of a choice; three numbers joined by commas, of which an
// RGB may give one for all three; `auto` where the row has it.  Ranges are the
// table's, closed at both ends, in the table's unit.
// Thread: any (values only).
#ifndef PROTOCOL_EDIT_H
#define PROTOCOL_EDIT_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/line.h"
#include "protocol/params.h"

#define EDIT_PIXELS_MAX 33000000 // image.width x image.height

// All pairs or, when one is refused, none: *p is then as it was.  Error codes:
// "unknown" (no such parameter; the text suggests the nearest name), "range",
// "type" (not a number, not a word of the choice ...).  err->name is the
// parameter.  E.g. `fibre.beta_r: 200 is not within [0.1, 60] deg`.
bool edit_apply(struct params *p, const struct line_pair *pairs, int count,
                struct error *err);

// The same for one "group.name=value", as on a command line.
bool edit_apply_text(struct params *p, const char *assignment,
                     struct error *err);

// The row of a name; else an "unknown" error with a suggestion.
const struct params_row *edit_find(struct span name, struct error *err);

// Appends the value as text that edit_apply reads back as the same value.
void edit_print(struct buf *out, const struct params *p,
                const struct params_row *row);

// Word i of a choice, i = 0 ..; size 0 when there is none.
struct span edit_choice(const struct params_row *row, int i);

// "WxH", each side within the rows image.width and image.height, at most
// EDIT_PIXELS_MAX in all.  `name` is what errors call it ("size", "--size").
bool edit_size(struct span text, const char *name, int *width, int *height,
               struct error *err);

#endif
