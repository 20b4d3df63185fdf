// forward.h - the paper's way of drawing: every visible fragment of a strand is
// shaded in a fragment shader, a few lights a pass, passes added up by blending
// (Xu 2011, section 5).  Shadows, lights, scattering and coverage are those of
// direct shading (the same shader functions, the same raster of ids); what
// differs is where on the hair they are evaluated: at the fragment, not at the
// middle of its cell, and that every sample is shaded anew.
//
// A pre-pass finds what each pixel sees, so that nothing hidden is shaded; the
// first sample's is kept for the edits to come, and its fragments'
// transmittances are kept as those of cells are (nodes.h).
// Nothing is allocated before the first sample.
// Thread: render.
#ifndef RENDERER_FORWARD_H
#define RENDERER_FORWARD_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/nodes.h"
#include "renderer/picture.h"
#include "renderer/shading.h"
#include "renderer/strands.h"

enum { FORWARD_VARIANTS = 4, FORWARD_DEFINES = SHADING_DEFINES + 32 };

struct forward_variant {
    char defines[FORWARD_DEFINES];
    unsigned thin, wide; // programs; 0 where no strand needed one yet
    unsigned age;
};

struct forward {       // zero-initialised is empty
    bool centres;      // shade at the middle of cells; set by tests
    int lights_a_pass; // 0: the paper's 16; set by benches
    int width, height; // of what is below
    unsigned colour;   // RGBA32F: what the passes add up
    struct picture_gl_target seen[2]; // by the first sample, by another
    unsigned target[2];               // colour with the depth of each
    bool first_kept;       // seen[0] holds this picture's first sample
    int listed;            // the sample whose fragments are listed; -1: none
    uint32_t first_places; // fragments of the first sample
    unsigned number, add;  // programs
    struct forward_variant variant[FORWARD_VARIANTS];
    unsigned clock;
    uint64_t bytes;
};

struct forward_pass {
    struct picture *picture;
    struct shading *shading;
    const struct strands *strands;
    const struct nodes_store *nodes; // of the listed fragments; NULL: none
    int lights;                      // in use
};

void forward_finish(struct forward *f); // programs too
void forward_drop(struct forward *f);   // what depends on the picture's size
// Camera or strands changed, or the picture's buffers were used otherwise.
void forward_forget(struct forward *f);

// Must sample k be rastered?
bool forward_must_see(const struct forward *f, const struct picture *p, int k);
// The pre-pass of sample k.  The scene block is bound.
bool forward_see(struct forward *f, struct picture *p, const struct strands *s,
                 int k, struct error *err);
// Makes the picture's list that of sample k's fragments, for nodes_make.
// False: it is so already.  True: kept transmittances of sample k are void.
bool forward_list(struct forward *f, struct picture *p, int k);
// Binds ids for nodes_make and all that follows; what is drawn begins anew.
void forward_bind(const struct forward *f, const struct picture *p, int k);

// The passes of sample k: of all its fragments, or of those whose
// transmittances `nodes` has; called again for the others.  Then it is added to
// the picture's sums.
bool forward_shade(struct forward *f, const struct forward_pass *pass, int k,
                   struct error *err);
void forward_add(const struct forward *f, const struct picture *p);

#endif
