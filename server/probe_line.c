// probe_line.c - see the header.
#include "server/probe_line.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/params.h"

static const double pi = 3.14159265358979323846;
#define QUARTER 1.5707963267948966
#define TURN 6.283185307179586

struct column {
    const char *name;
    const char *row; // of the parameter table, which has the range
    double min, max; // where there is no row
};

static const struct column eta = {"eta", "fibre.eta", 0, 0},
                           sigma_a = {"sigma_a", "fibre.sigma_a", 0, 0},
                           alpha_r = {"alpha_R", "fibre.alpha_r", 0, 0},
                           alpha_tt = {"alpha_TT", "fibre.alpha_tt", 0, 0},
                           alpha_trt = {"alpha_TRT", "fibre.alpha_trt", 0, 0},
                           beta_r = {"beta_R", "fibre.beta_r", 0, 0},
                           beta_tt = {"beta_TT", "fibre.beta_tt", 0, 0},
                           beta_trt = {"beta_TRT", "fibre.beta_trt", 0, 0},
                           w_c = {"w_c", "fibre.w_c", 0, 0},
                           a = {"a", "fibre.a", 0, 0},
                           lambda_j = {"lambda_j", NULL, 1e-3, 2},
                           theta_j = {"theta_j", NULL, -QUARTER, QUARTER},
                           phi_j = {"phi_j", NULL, -TURN, TURN},
                           theta_o = {"theta_o", NULL, -QUARTER, QUARTER},
                           phi_o = {"phi_o", NULL, -TURN, TURN},
                           theta_i = {"theta_i", NULL, -QUARTER, QUARTER},
                           phi = {"Phi", NULL, -TURN, TURN},
                           sigma_f = {"sigma_f", NULL, 1e-3, 100};

#define FIBRE \
    &eta, &sigma_a, &alpha_r, &alpha_tt, &alpha_trt, &beta_r, &beta_tt, \
        &beta_trt, &w_c
#define FIBRE_NAMES \
    "eta sigma_a alpha_R alpha_TT alpha_TRT beta_R beta_TT beta_TRT w_c "
#define FIFTEEN FIBRE, &a, &lambda_j, &theta_j, &phi_j, &theta_o, &phi_o
#define FIFTEEN_NAMES FIBRE_NAMES "a lambda_j theta_j phi_j theta_o phi_o"

static const struct {
    const struct column *column[PROBE_LINE_MAX];
    const char *names;
} forms[PROBE_LINE_FORMS] = {
    [PROBE_LINE_SINGLE] = {{FIFTEEN}, FIFTEEN_NAMES},
    [PROBE_LINE_FIBRE] = {{FIBRE, &theta_i}, FIBRE_NAMES "theta_i"},
    [PROBE_LINE_HALF] = {{FIBRE, &theta_i, &phi}, FIBRE_NAMES "theta_i Phi"},
    [PROBE_LINE_MULTIPLE] = {{FIFTEEN, &sigma_f}, FIFTEEN_NAMES " sigma_f"},
    [PROBE_LINE_LIT] = {{FIFTEEN, &sigma_f}, FIFTEEN_NAMES " sigma_f"},
};

static void range_of(const struct column *column, double *min, double *max)
{
    *min = column->min;
    *max = column->max;
    if (!column->row)
        return;
    const struct params_row *row =
        params_find(column->row, strlen(column->row));
    double unit = strcmp(row->unit, "deg") == 0 ? pi / 180 : 1;
    *min = row->min * unit;
    *max = row->max * unit;
}

// A bound may come rounded to a few digits (1.5708 for pi/2): up to a part in
// 10^4 beyond counts as the bound.
static bool within(const struct column *column, double *value)
{
    double min, max;
    range_of(column, &min, &max);
    double lo = min - 1e-4 * fabs(min), hi = max + 1e-4 * fabs(max);
    if (!(*value >= lo && *value <= hi))
        return false;
    *value = fmin(fmax(*value, min), max);
    return true;
}

static bool range_error(const struct column *column, double value, long line,
                        struct error *err)
{
    double min, max;
    range_of(column, &min, &max);
    return error_set(err, "range", column->name,
                     "line %ld: %s: %.9g is not within [%.9g, %.9g]", line,
                     column->name, value, min, max);
}

// Decimal only, but as loosely as tools print it: "1." and ".5" will do.
static bool parse_number(const char *text, size_t size, double *out)
{
    char *end;
    if (strspn(text, "0123456789+-.eE") < size)
        return false;
    *out = strtod(text, &end);
    return end == text + size && isfinite(*out);
}

int probe_line_count(enum probe_line_form form)
{
    int count = 0;
    while (count < PROBE_LINE_MAX && forms[form].column[count])
        count++;
    return count;
}

const char *probe_line_names(enum probe_line_form form)
{
    return forms[form].names;
}

bool probe_line_parse(enum probe_line_form form, const char *text, long line,
                      double out[PROBE_LINE_MAX], struct error *err)
{
    static const char blanks[] = " \t\r\n\v\f";
    int count = 0, wanted = probe_line_count(form);
    for (;; count++) {
        text += strspn(text, blanks);
        size_t size = strcspn(text, blanks);
        if (size == 0)
            break;
        if (count < wanted) {
            const struct column *column = forms[form].column[count];
            if (!parse_number(text, size, &out[count]))
                return error_set(err, "syntax", column->name,
                                 "line %ld: %s: \"%.*s\" is not a finite "
                                 "number",
                                 line, column->name, size > 40 ? 40 : (int)size,
                                 text);
            if (!within(column, &out[count]))
                return range_error(column, out[count], line, err);
        }
        text += size;
    }
    if (count != wanted)
        return error_set(err, "syntax", "line",
                         "line %ld: %d numbers, %d are wanted: %s", line, count,
                         wanted, forms[form].names);
    return true;
}
