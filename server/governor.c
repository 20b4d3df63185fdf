// governor.c - remembers a choice, what was measured since, and when to choose
// anew.  The choice is governor_choice.c's; who measures, and who draws what is
// chosen, is hub.c's and studio.c's affair.
#include "server/governor.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "protocol/edit.h"
#include "renderer/metric.h"
#include "server/bench_knobs.h"

// What was measured has moved: by half a step (of a factor of two) from one
// setting to the next, so that a choice that changed does not change back for
// noise.
static const double moved = 1.4;

// --- what was measured -------------------------------------------------------

static void see(struct governor_ratio *r, double value)
{
    if (!(value > 0) || !isfinite(value))
        return;
    if (r->count == GOVERNOR_SEEN) {
        memmove(r->seen, r->seen + 1, sizeof r->seen - sizeof r->seen[0]);
        r->count--;
    }
    r->seen[r->count++] = value;
}

static double ratio(const struct governor_ratio *r)
{
    return r->count > 0 ? metric_quantile(r->seen, (size_t)r->count, 0.5) : 1;
}

// What comes now weighs more than what was seen before.
static void age(struct governor_ratio *r)
{
    if (r->count > 1)
        *r = (struct governor_ratio){{ratio(r)}, 1};
}

void governor_took(struct governor *g, const struct governor_note *note,
                   double ms)
{
    if (note->front_ms > 0)
        see(&g->time, ms / note->front_ms);
}

void governor_judged(struct governor *g, const struct governor_note *note,
                     double error)
{
    if (note->front_error > 0)
        see(&g->error, error / note->front_error);
}

// --- a new state -------------------------------------------------------------

// What a front says nothing about.
static const char *unlike(const struct params *p)
{
    struct params d;
    params_defaults(&d);
    if (p->shadow.method != d.shadow.method)
        return "fronts are measured with shadow.method=crossings";
    if (p->render.components != d.render.components)
        return "fronts are measured with render.components=all";
    if (bench_knobs_forward(p))
        return "fronts are measured without render.path=forward";
    return NULL;
}

static const char *reason(const struct governor *g, const struct params *p)
{
    const bool budget = p->quality.budget_ms > 0;
    switch (g->choice.verdict) {
    case GOVERNOR_FITS:
        return p->quality.error <= 0 ? "the least error within the budget"
               : budget              ? "the quickest within error and budget"
                                     : "the quickest within the error";
    case GOVERNOR_NEAREST:
        return budget ? "nothing measured is within the budget: the quickest"
                      : "nothing measured is within the error: the least";
    case GOVERNOR_LATE:
        return "nothing measured is within both: the least error within the "
               "budget";
    default:
        return g->front ? "nothing like these settings was measured"
                        : "there is no front";
    }
}

static bool unchanged(const struct governor *g, const struct governor_state *s,
                      const struct front *front, double key[12])
{
    const struct params *p = s->params;
    int n = 0;
    for (int k = 0; k < FRONT_KNOBS; k++)
        key[n++] = front_knob(p, k);
    key[n++] = (double)p->quality.budget_ms;
    key[n++] = (double)p->quality.error;
    key[n++] = p->image.width;
    key[n++] = p->image.height;
    key[n++] = unlike(p) ? 1 : 0;
    while (n < 12)
        key[n++] = 0;
    return front == g->front && memcmp(key, g->key, sizeof g->key) == 0;
}

// An error says nothing about another scene; a time says something, of the
// machine.
static bool another_scene(struct governor *g, const struct front_scene *s)
{
    if (strcmp(g->hair, s->hair) == 0 && strcmp(g->env, s->env) == 0)
        return false;
    snprintf(g->hair, sizeof g->hair, "%s", s->hair);
    snprintf(g->env, sizeof g->env, "%s", s->env);
    g->error.count = 0;
    return true;
}

static bool drifted(double now, double then)
{
    return now > then * moved || now * moved < then;
}

static void note(struct governor *g, const struct params *p)
{
    const struct governor_choice *c = &g->choice;
    struct governor_note *n = &g->note;
    struct buf text = {0};
    *n = (struct governor_note){.why = ""};
    if (c->row >= 0) {
        const struct front_row *r = &g->front->row[c->row];
        const struct front_row *b = &g->front->row[c->base];
        n->front_ms = r->first_ms[FRONT_FIBRE];
        n->front_error = r->error;
        n->expects_ms = g->used_time * r->first_ms[FRONT_FIBRE];
        n->expects_error = g->used_error * r->error;
        n->default_ms = g->used_time * b->first_ms[FRONT_FIBRE];
        n->default_error = g->used_error * b->error;
    }
    if (p->quality.budget_ms > 0)
        buf_printf(&text, "quality.budget_ms=%g", (double)p->quality.budget_ms);
    if (p->quality.error > 0)
        buf_printf(&text, "%squality.error=%g", text.size ? " " : "",
                   (double)p->quality.error);
    snprintf(n->asked, sizeof n->asked, "%.*s", (int)text.size,
             (const char *)text.data);
    if (text.size > 0)
        n->why = unlike(p) ? unlike(p) : reason(g, p);
    buf_finish(&text);
}

// Chooses anew where there is reason to.
static void update(struct governor *g, const struct governor_state *s)
{
    double key[12];
    const struct front *front = fronts_nearest(&g->fronts, &s->scene);
    const bool another = another_scene(g, &s->scene);
    const bool same = unchanged(g, s, front, key) && !another;
    const bool held = s->now_us - g->edited_us < GOVERNOR_HOLD_US;
    g->edited_us = s->now_us;
    if (!same) {
        age(&g->time);
        age(&g->error);
    }
    const double time = ratio(&g->time), error = ratio(&g->error);
    if (same && (held || (!drifted(time, g->used_time) &&
                          !drifted(error, g->used_error))))
        return;
    g->front = front;
    memcpy(g->key, key, sizeof g->key);
    g->used_time = time;
    g->used_error = error;
    const struct governor_ask ask = {front, s->params, time, error};
    g->choice = unlike(s->params)
                    ? (struct governor_choice){GOVERNOR_NONE, -1, -1}
                    : governor_choose(&ask);
    note(g, s->params);
}

void governor_resolve(struct governor *g, const struct governor_state *state,
                      struct params *out)
{
    const struct params *p = state->params;
    double before[FRONT_KNOBS], after[FRONT_KNOBS];
    update(g, state);
    *out = *p;
    out->quality.budget_ms = 0;
    out->quality.error = 0;
    for (int k = 0; k < FRONT_KNOBS; k++) {
        before[k] = after[k] = front_knob(p, k);
        if (g->choice.verdict != GOVERNOR_NONE && !governor_pinned(p, k))
            after[k] = g->front->row[g->choice.row].knob[k];
        front_put(out, k, after[k]);
    }
    struct buf set = {0};
    front_print_knobs(&set, after, before);
    snprintf(g->note.set, sizeof g->note.set, "%.*s", (int)set.size,
             (const char *)set.data);
    buf_finish(&set);
}

void governor_finish(struct governor *g)
{
    fronts_finish(&g->fronts);
}

// --- telling -----------------------------------------------------------------

void governor_text(const struct governor_note *n, char *out, size_t room)
{
    snprintf(out, room, "%s: %s", n->asked, n->set[0] ? n->set : "as set");
}

void governor_put_line(struct json *j, const struct governor_note *n)
{
    char text[256], line[512];
    governor_text(n, text, sizeof text);
    snprintf(line, sizeof line, "%s (%s)", text, n->why);
    json_string(j, line);
}

static void put_ratio(struct json *j, const char *key,
                      const struct governor_ratio *r, double used)
{
    json_key(j, key);
    json_open_object(j);
    json_put_number(j, "used", used);
    json_put_number(j, "now", ratio(r));
    json_put_int(j, "seen", r->count);
    json_close_object(j);
}

static void put_known(struct json *j, const char *key, double value)
{
    json_key(j, key);
    if (value > 0)
        json_number(j, value);
    else
        json_null(j);
}

void governor_put(struct json *j, const struct governor *g)
{
    const struct governor_note *n = &g->note;
    if (!n->asked[0]) {
        json_null(j);
        return;
    }
    json_open_object(j);
    json_put_string(j, "asked", n->asked);
    json_put_string(j, "set", n->set);
    json_put_string(j, "why", n->why);
    put_known(j, "expects_ms", n->expects_ms);
    put_known(j, "expects_error", n->expects_error);
    put_known(j, "default_ms", n->default_ms);
    put_known(j, "default_error", n->default_error);
    json_put_string(j, "front", g->front ? g->front->scene : NULL);
    json_put_string(j, "front_device", g->front ? g->front->device : NULL);
    json_put_bool(j, "front_shipped", g->front && g->front->shipped);
    put_ratio(j, "time_ratio", &g->time, g->used_time);
    put_ratio(j, "error_ratio", &g->error, g->used_error);
    json_close_object(j);
}
