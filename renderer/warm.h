// warm.h - programs that the next edit may need, made before it comes: the
// states that differ from the present one by one edit are rendered, very small,
// in a renderer of their own.  What its driver compiled for them the driver's
// cache then has for every context of this machine, and their names let
// another renderer have them ready (renderer_prepare).
//
// Thread: any one at a time, from the first warm_step to warm_rest the same: it
// owns a GL context in between.
#ifndef RENDERER_WARM_H
#define RENDERER_WARM_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/groom.h"
#include "renderer/sky.h"

struct warm;

struct warm *warm_create(void);    // nothing of GL yet
void warm_destroy(struct warm *w); // after warm_rest; NULL is allowed

struct warm_scene { // what the states have in common
    struct params params;
    struct sky_fit fit; // of params.sky
    int sky_width, sky_height;
    struct groom *sample; // of the hair (warm_sample)
};
// A few strands of a groom, of two widths, such that all is drawn that can be
// drawn of it.  Thread: any that may read g.
struct groom *warm_sample(const struct groom *g);

// The scene's parameters and all that are one edit away from them: every word
// of each choice, and the values at which something is left out or comes in.
// Those that were rendered before, of hair with the same properties, are passed
// over.  Takes the sample.
void warm_begin(struct warm *w, const struct warm_scene *scene);
int warm_left(const struct warm *w); // states to render
int warm_done(const struct warm *w); // in all
// Renders the next of them.  Appends to *names, a line each, the programs that
// were not named before.  False: this state could not be rendered.
bool warm_step(struct warm *w, struct buf *names, struct error *err);
// Frees what is not needed between two rounds: the renderer and its context.
void warm_rest(struct warm *w);

#endif
