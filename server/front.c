// front.c - knobs, looks up fronts, writes them.  front_read.c reads them; what
// is chosen from one is governor.c's affair, how one is measured
// bench_front.c's.
#include "server/front.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/edit.h"

const char front_magic[] = "glint.front 1\n";

const char *const front_knob_names[FRONT_KNOBS] = {
    "sky.lights", "quality.light_bound", "shadow.resolution",
    "shadow.directions", "shadow.rays"};

const char *const front_time_names[FRONT_EDITS] = {"fibre_ms", "sky_ms",
                                                   "camera_ms"};

// --- knobs -------------------------------------------------------------------

static const struct params_row *row_of(int knob)
{
    return params_find(front_knob_names[knob], strlen(front_knob_names[knob]));
}

double front_knob(const struct params *p, int knob)
{
    return params_get(p, row_of(knob), 0);
}

double front_knob_default(int knob)
{
    return (double)(float)row_of(knob)->def[0]; // as a struct params has it
}

void front_put(struct params *p, int knob, double value)
{
    params_put(p, row_of(knob), 0, value);
}

void front_print_knobs(struct buf *out, const double knob[FRONT_KNOBS],
                       const double from[FRONT_KNOBS])
{
    struct params p;
    const char *blank = "";
    params_defaults(&p);
    for (int k = 0; k < FRONT_KNOBS; k++) {
        if (knob[k] == from[k])
            continue;
        front_put(&p, k, knob[k]);
        buf_text(out, blank);
        buf_text(out, front_knob_names[k]);
        buf_byte(out, '=');
        edit_print(out, &p, row_of(k));
        blank = " ";
    }
}

void fronts_finish(struct fronts *f)
{
    free(f->item);
    *f = (struct fronts){0};
}

// --- looking up --------------------------------------------------------------

// Octaves between the numbers of strands.  Another sky counts as an octave,
// another device as a little: times are scaled to this machine, errors are not
// the machine's.
static double distance(const struct front *f, const struct front_scene *s)
{
    double d = 0;
    if (strcmp(f->hair, s->hair) != 0)
        d += 0.01 + fabs(log2((double)f->strands / fmax(s->strands, 1)));
    d += strcmp(f->env, s->env) != 0;
    return d + (strcmp(f->device, s->device) == 0 ? 0 : 0.005);
}

const struct front *fronts_nearest(const struct fronts *f,
                                   const struct front_scene *scene)
{
    const struct front *best = NULL;
    for (int i = 0; i < f->count; i++)
        if (!best || distance(&f->item[i], scene) < distance(best, scene))
            best = &f->item[i];
    return best;
}

// --- writing -----------------------------------------------------------------

static void print_text(struct buf *out, const char *key, const char *value)
{
    buf_printf(out, " %s=\"", key);
    for (; *value; value++) {
        if (*value == '"' || *value == '\\')
            buf_byte(out, '\\');
        buf_byte(out, (unsigned char)*value);
    }
    buf_byte(out, '"');
}

void front_print(const struct front *f, struct buf *out)
{
    double defaults[FRONT_KNOBS];
    for (int k = 0; k < FRONT_KNOBS; k++)
        defaults[k] = front_knob_default(k);
    buf_text(out, "front");
    print_text(out, "device", f->device);
    buf_printf(out, " cores=%d", f->cores);
    print_text(out, "scene", f->scene);
    print_text(out, "hair", f->hair);
    print_text(out, "env", f->env);
    buf_printf(out, " strands=%u\n", f->strands);
    for (int i = 0; i < f->rows; i++) {
        const struct front_row *r = &f->row[i];
        struct buf knobs = {0};
        front_print_knobs(&knobs, r->knob, defaults);
        buf_printf(out, "row%s", knobs.size > 0 ? " " : "");
        buf_append(out, knobs.data, knobs.size);
        for (int e = 0; e < FRONT_EDITS; e++)
            buf_printf(out, " %s=%.5g", front_time_names[e], r->first_ms[e]);
        buf_printf(out, " rest_ms=%.5g error=%.5g\n", r->rest_ms, r->error);
        buf_finish(&knobs);
    }
}
