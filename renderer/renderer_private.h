// renderer_private.h - the renderer's inside, shared by its files: renderer.c
// (what is stale), renderer_setup.c (stages that set up), renderer_sample.c (a
// sample, reading), renderer_draft.c and renderer_draft_parts.c (drafts and
// what they are made of), renderer_places.c (places for comparison),
// renderer_report.c (stats).
#ifndef RENDERER_RENDERER_PRIVATE_H
#define RENDERER_RENDERER_PRIVATE_H

#include "renderer/renderer.h"

#include "renderer/camera.h"
#include "renderer/crossings.h"
#include "renderer/display.h"
#include "renderer/draft.h"
#include "renderer/forward.h"
#include "renderer/layers.h"
#include "renderer/lights.h"
#include "renderer/nodes.h"
#include "renderer/picture.h"
#include "renderer/shading.h"
#include "renderer/strands.h"
#include "renderer/timer.h"
#include "renderer/watch.h"

struct egl;

struct renderer {
    struct egl *egl;
    char *cache_dir; // NULL: none
    struct groom *groom;
    struct sky_map *map;
    struct params params;
    struct sky_fit fit;
    struct strands strands;
    struct lights lights;
    struct crossings crossings;
    bool grid_stale;  // of the crossings
    bool lists_tried; // for this grid, with success or too little room
    int grid_resolution, grid_memory_mb, grid_method; // made for
    int directions_quality;
    bool directions_stale; // lights stand elsewhere than swept for
    struct nodes nodes;
    int path; // that picture and nodes were made for: forward or direct
    // bytes; 0: half of quality.cache_mb; set by tests, drafts, warm.c
    uint64_t nodes_budget, lit_budget;
    struct shading shading;
    struct picture picture;
    struct layers layers;
    struct forward forward;
    struct display display;
    struct camera camera;
    struct timer timer;
    unsigned places; // program of renderer_places.c; 0: not asked for yet
    bool stale[RENDERER_STAGES]; // of those that set up
    bool idle;                   // set by a stage that found nothing to do
    bool drafting;               // this sample is a draft's
    int samples;                 // in the picture's sum
    bool refined;                // the picture's shadows are by rays
    struct renderer_stats stats;
    struct gl_counts work_from;     // when the newest step or draft began
    struct renderer_first {         // of the newest first sample of a size
        int width, height;          // 0: there was none
        double ms[RENDERER_STAGES]; // that ran the stage; < 0: none did
    } first[2];                     // the newer size first
    struct draft draft;
    struct watch watch;
    double part[3]; // places in one part of a sample's work
};

// Of the size that is asked for, or else the newest; NULL: there was none.
const struct renderer_first *renderer_first_of(const struct renderer *r);
// Bits of a stage and all that come after it.
uint32_t renderer_after(const struct renderer *r, enum renderer_stage first);

// What a stage reads changed (first: the first stage that is marked).
void renderer_draft_mark(struct renderer *r, enum renderer_stage first);
// As renderer_read_display, of the draft.
bool renderer_draft_read(struct renderer *r, struct buf *out,
                         struct error *err);
// A sky was fitted, or (fit NULL) there is another sky.
void renderer_draft_fitted(struct renderer *r, const struct sky_fit *fit);

// --- renderer_draft_parts.c
// Parameters of the whole picture as a draft of that size has them.
struct params renderer_draft_params(const struct renderer *r, int divisor);
// Does the draft at hand have strands of its own?
bool renderer_draft_owns_strands(const struct renderer *r);
// Makes what the draft at hand (draft.now) needs, where it is not there; true
// when it is.
bool renderer_draft_parts(struct renderer *r, struct error *err);

// Runs a stage that sets up if it is stale.
bool renderer_run_setup(struct renderer *r, enum renderer_stage i,
                        struct error *err);
// Is there no grid for this hair, or are there no directions for these lights?
bool renderer_crossings_due(const struct renderer *r);
// Uploads the scene block of sample k; the blocks of lights and parameters.
void renderer_bind_scene(struct renderer *r, int k);
bool renderer_wait_for_gpu(const char *doing, struct error *err);

// Marks a stage and all that come after it.
void renderer_mark(struct renderer *r, enum renderer_stage first);
// The words of render.path.
enum { RENDERER_DIRECT, RENDERER_FORWARD, RENDERER_TABLE };
// Is the sky's tint a common factor of all that is summed, to be multiplied by
// where sums and cells are read?  Then an edit of it shades nothing.
bool renderer_tint_apart(const struct params *p);
// Before anything is read: an edit of such a tint asks for no step.
void renderer_freshen_tint(struct renderer *r);
// True when shadows are asked for and there is light to be shadowed.
bool renderer_shadowed(const struct renderer *r);
// ... and they come from depth maps, not from the field of crossings.
bool renderer_mapped(const struct renderer *r);
// Rays for each light and place of a refined picture; 0 where none are asked
// for, or where the lists that they need have no room.
int renderer_rays(const struct renderer *r);

// The stages light and tint, of another fit than the one asked for.
void renderer_light_by(struct renderer *r, struct sky_fit *fit);
// The stage fibre, but for the axis of the strands; draft: with the tables of
// render.tables that are there.
void renderer_shade_by(struct renderer *r, const struct strands *s, bool draft);
// Fills directions for the lights as they stand; returns how many.
int renderer_crossings_lights(const struct renderer *r,
                              struct crossings_light out[LIGHTS_MAX]);

typedef bool renderer_setup_fn(struct renderer *r, struct error *err);
renderer_setup_fn renderer_setup_strands, renderer_setup_sky,
    renderer_setup_light, renderer_setup_tint, renderer_setup_crossings,
    renderer_setup_fibre, renderer_setup_visible;

bool renderer_sample(struct renderer *r, struct error *err);

#endif
