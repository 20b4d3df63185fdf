// probe_line.h - one line of numbers on the input of `glintd probe`: which are
// wanted, in which order and range.  Ranges of the fibre's are the parameter
// table's.
// Thread: any.
#ifndef SERVER_PROBE_LINE_H
#define SERVER_PROBE_LINE_H

#include <stdbool.h>

#include "protocol/error.h"

enum probe_line_form {
    PROBE_LINE_SINGLE,   // the fifteen of struct exact_case
    PROBE_LINE_FIBRE,    // the fibre but for a, theta_i
    PROBE_LINE_HALF,     // the same, Phi
    PROBE_LINE_MULTIPLE, // the fifteen, sigma_f
    PROBE_LINE_LIT,      // the same
    PROBE_LINE_FORMS
};

enum { PROBE_LINE_MAX = 16 };

int probe_line_count(enum probe_line_form form);
const char *probe_line_names(enum probe_line_form form); // between blanks

// The numbers of `text` in order.  False, and *err names the line, the number,
// its value and range.  Values a part in 10^4 beyond a bound are the bound.
bool probe_line_parse(enum probe_line_form form, const char *text, long line,
                      double out[PROBE_LINE_MAX], struct error *err);

#endif
