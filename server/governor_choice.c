// governor_choice.c - the choice itself: of a front's rows, the one that a
// budget or a wanted error comes to.
#include "server/governor.h"

#include <math.h>

// Another kind of edit counts as slower only beyond what two measurements of
// the same thing differ by.
static const double same_time = 1.1;
// --- candidates --------------------------------------------------------------

bool governor_pinned(const struct params *p, int knob)
{
    return front_knob(p, knob) != front_knob_default(knob) ||
           (knob == FRONT_RAYS && p->quality.error <= 0);
}

// Leaves the rows that have the value nearest to the user's.
static void keep_nearest(const struct front *f, int knob, double value,
                         bool *in)
{
    double least = INFINITY;
    for (int i = 0; i < f->rows; i++)
        if (in[i])
            least = fmin(least, fabs(f->row[i].knob[knob] - value));
    for (int i = 0; i < f->rows; i++)
        in[i] = in[i] && fabs(f->row[i].knob[knob] - value) <= least;
}

// Those that the user's knobs allow; returns the default's among them, or -1.
static int candidates(const struct governor_ask *ask, bool *in)
{
    const struct front *f = ask->front;
    int base = -1;
    for (int i = 0; i < f->rows; i++)
        in[i] = true;
    for (int k = 0; k < FRONT_KNOBS; k++)
        if (governor_pinned(ask->params, k))
            keep_nearest(f, k, front_knob(ask->params, k), in);
    for (int i = 0; i < f->rows; i++) {
        bool is = in[i];
        for (int k = 0; is && k < FRONT_KNOBS; k++)
            is = governor_pinned(ask->params, k) ||
                 f->row[i].knob[k] == front_knob_default(k);
        if (is && base < 0)
            base = i;
    }
    return base;
}

// --- the choice --------------------------------------------------------------

// Everything that a row is weighed by; less is better.
struct weight {
    double first;    // ms, of a fibre edit
    double relative; // mean over the kinds of edit, to the default's
    double error;
    bool slower; // another kind of edit is too slow for the budget
};

static struct weight weigh(const struct governor_ask *ask, int row, int base)
{
    const struct front_row *r = &ask->front->row[row];
    const struct front_row *b = &ask->front->row[base];
    struct weight w = {.first = ask->time_ratio * r->first_ms[FRONT_FIBRE],
                       .relative = r->rest_ms / b->rest_ms,
                       .error = ask->error_ratio * r->error};
    for (int e = 0; e < FRONT_EDITS; e++) {
        const double allowed =
            fmax((double)ask->params->quality.budget_ms,
                 ask->time_ratio * same_time * b->first_ms[e]);
        w.slower |= ask->time_ratio * r->first_ms[e] > allowed;
        w.relative += r->first_ms[e] / b->first_ms[e];
    }
    w.relative /= 1 + FRONT_EDITS;
    return w;
}

enum aim { LEAST_ERROR, LEAST_TIME, SOONEST };

static bool better(const struct weight *a, const struct weight *b, enum aim aim)
{
    const double x[2] = {aim == LEAST_ERROR  ? a->error
                         : aim == LEAST_TIME ? a->relative
                                             : a->first,
                         aim == LEAST_ERROR ? a->relative : a->error};
    const double y[2] = {aim == LEAST_ERROR  ? b->error
                         : aim == LEAST_TIME ? b->relative
                                             : b->first,
                         aim == LEAST_ERROR ? b->relative : b->error};
    return x[0] < y[0] || (x[0] == y[0] && x[1] < y[1]);
}

struct limits {
    double first, error; // INFINITY: none
    enum aim aim;
};

// The best row within limits, or -1.
static int best(const struct governor_ask *ask, const bool *in, int base,
                const struct limits *l)
{
    struct weight top = {0};
    int found = -1;
    for (int i = 0; i < ask->front->rows; i++) {
        if (!in[i])
            continue;
        const struct weight w = weigh(ask, i, base);
        if (w.first > l->first || w.error > l->error ||
            (w.slower && ask->params->quality.budget_ms > 0))
            continue;
        if (found >= 0 && !better(&w, &top, l->aim))
            continue;
        found = i;
        top = w;
    }
    return found;
}

struct governor_choice governor_choose(const struct governor_ask *ask)
{
    struct governor_choice c = {GOVERNOR_NONE, -1, -1};
    bool in[FRONT_ROWS_MAX];
    if (!ask->front)
        return c;
    c.row = c.base = candidates(ask, in);
    const double budget = (double)ask->params->quality.budget_ms;
    const double error = (double)ask->params->quality.error;
    if (c.base < 0 || (budget <= 0 && error <= 0))
        return c;
    const enum aim aim = error > 0 ? LEAST_TIME : LEAST_ERROR;
    const struct limits both = {budget > 0 ? budget : INFINITY,
                                error > 0 ? error : INFINITY, aim};
    const struct limits late = {both.first, INFINITY, LEAST_ERROR};
    const struct limits none = {INFINITY, INFINITY,
                                budget > 0 ? SOONEST : LEAST_ERROR};
    c.verdict = GOVERNOR_FITS;
    c.row = best(ask, in, c.base, &both);
    if (c.row < 0 && budget > 0 && error > 0) {
        c.verdict = GOVERNOR_LATE;
        c.row = best(ask, in, c.base, &late);
    }
    if (c.row < 0) {
        c.verdict = GOVERNOR_NEAREST;
        c.row = best(ask, in, c.base, &none); // base itself is never slower
    }
    return c;
}
