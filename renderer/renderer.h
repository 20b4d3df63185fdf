// renderer.h - the one door into the renderer: parameters in, picture out.
//
// A renderer owns the EGL context, one groom, one sky and one picture that is
// being refined.  Progress comes in steps, so that the caller can look for a
// newer edit between two: renderer_step runs the stages that the last changes
// made stale and adds one sample to the picture.
// Thread: the one that calls renderer_create, for every function here.
#ifndef RENDERER_RENDERER_H
#define RENDERER_RENDERER_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/gl_count.h"
#include "renderer/groom.h"
#include "renderer/sky.h"

struct renderer;

enum renderer_stage {   // in the order in which they run
    RENDERER_STRANDS,   // hair: vertex buffers
    RENDERER_SKY,       // sky: the fit, lights in the map's frame
    RENDERER_LIGHT,     // light, suns: lights in the world, those that matter
    RENDERER_TINT,      // tint, suns: their colours
    RENDERER_CROSSINGS, // shadow: fibres crossed on the way to any point
    RENDERER_FIBRE,     // fibre, render: program variant, uniforms, tables
    RENDERER_VISIBLE,   // camera, image: which place of which strand a pixel
                        // sees
    RENDERER_SHADOW,    // what of each light reaches each visible place
    RENDERER_SHADE,     // radiance of the visible places
    RENDERER_RESOLVE,   // accumulation, coverage
    RENDERER_DISPLAY,   // view: the 8-bit picture
    RENDERER_READ,      // pixels to the caller
    RENDERER_STAGES
};
extern const char *const renderer_stage_names[RENDERER_STAGES];

struct renderer_left_out { // what this scene did not need
    const char *what;      // "eccentricity", "tt_trt", "lights"
    char why[96];
    double bound; // largest relative error that leaving it out can cause
};

struct renderer_draft {
    int divisor; // of width and height, 1 to RENDERER_DRAFT_MOST
    int stride;  // every so many-th strand, as many times as wide; the same
    // Set by renderer_draft:
    bool coarse; // shadows are a coarse field's
    bool fitted; // lights are those of a sky fit that was there already
};
enum { RENDERER_DRAFT_MOST = 16, RENDERER_DRAFT_VIEWS = 4 };

struct renderer_stats {
    double stage_ms[RENDERER_STAGES]; // of the last step; < 0: did not run
    int samples;                      // accumulated so far
    int samples_wanted;
    uint32_t visible_points;        // shaded by the last step
    int lights_used, lights_fitted; // suns count among those used
    // render.path=table: tables that these share; lights that have none
    int tables, tables_missing;
    bool refined; // this picture's shadows are being made by real rays
    int shadow_resolution, shadow_directions; // in use; 0: no shadows
    double shadow_grid_ms, shadow_sweep_ms;   // of the last build
    struct renderer_left_out left_out[14];
    int left_out_count;
    float diameter;          // in use, file units (see hair.diameter)
    double strand_pixels;    // how wide that is at the camera's target
    int up;                  // 0, 1, 2: the axis taken as up (see hair.up)
    float eye[3], target[3]; // in use, world (see camera.eye = auto)
    const char *path;        // that drew it: a word of render.path
    uint64_t memory_strands, memory_targets, memory_cache; // bytes
    uint64_t memory_shadow, memory_draft;
    uint64_t memory_tables;     // of render.path=table
    uint64_t programs_compiled; // since the start
    size_t programs;            // kept
    struct gl_counts work;      // since the newest step or draft began
    struct sky_fit fit;
    struct sky_cleaned cleaned;
};

// cache_dir: for fits; NULL keeps none.
struct renderer *renderer_create(const char *cache_dir, struct error *err);
void renderer_destroy(struct renderer *r); // NULL is allowed
const char *renderer_device(const struct renderer *r);

// Takes ownership of the groom or map, whether it succeeds or not.  On failure
// the one in use stays.
bool renderer_set_groom(struct renderer *r, struct groom *g, struct error *err);
bool renderer_set_sky(struct renderer *r, struct sky_map *m, struct error *err);

// Values as they passed the table's checks.  Marks what reads a changed group
// as stale; does no work.  True when samples or a draft were lost, because the
// picture starts anew: not where only `view` or `output` changed, nor where
// `tint` is a factor of the whole (no sun shines and light is shown); those
// take effect when the picture is read.
bool renderer_set_params(struct renderer *r, const struct params *p);

// `newer` is asked every few milliseconds of a step or a rehearsal whether
// something newer waits; when it says so, the work is left where it is, and
// what it was to make stays as stale as it was: the next step begins it anew.
// It may be called on any thread.  NULL: nobody is asked.
void renderer_watch(struct renderer *r, bool (*newer)(void *ctx), void *ctx);
// Was the newest step or rehearsal left so?
bool renderer_was_cut(const struct renderer *r);

// One step.  *done is true when the picture is final (samples_wanted reached).
// With shadow.rays the first step gives a picture with the smooth shadow field;
// then the picture begins anew, refined by rays.
// After an error the stages that failed are still stale.
bool renderer_step(struct renderer *r, bool *done, struct error *err);

// What the first sample of the picture as it is asked for now would take, by
// stage, going by what these stages took in the newest such sample of this
// size: ms, < 0: it would not run.  False where there is nothing to go by,
// where a sample is there already, or where there are no drafts: of another
// sky, with render.path=forward, with shadow.method=map, of parts as layers.
bool renderer_forecast(const struct renderer *r, double ms[RENDERER_STAGES]);
// The same of an edit to come that would make `first` and what follows from it
// stale; of a picture that has samples already.
bool renderer_foresee(const struct renderer *r, enum renderer_stage first,
                      double ms[RENDERER_STAGES]);
// Makes a draft of the picture as it is asked for, apart from it: smaller, of
// fewer strands, and where lights or hair moved with shadows of a coarse field.
// Where the sky has to be fitted anew, with lights out of an earlier fit.  Its
// time is in stage_ms of the stats.  Where renderer_forecast returns true. What
// is asked of the picture itself stays asked, and comes out the same bit for
// bit.  how->stride may come back larger: not all strands have what they need.
// Memory is taken with the first draft of a size.
bool renderer_draft(struct renderer *r, struct renderer_draft *how,
                    struct error *err);
// Drafts whose camera and hair are those asked for, so that they need no
// raster: into out, most recent first; returns how many.
int renderer_drafts_seen(const struct renderer *r,
                         struct renderer_draft out[RENDERER_DRAFT_VIEWS]);
// Makes the draft that an edit of `first` (STRANDS, CROSSINGS, VISIBLE or
// FIBRE) would get, for nobody to see: what it needs is there then, and ms is
// what its stages took.  Where renderer_foresee returns true.  The picture goes
// on as if nothing had been, and so do the stats.
bool renderer_rehearse(struct renderer *r, enum renderer_stage first,
                       struct renderer_draft *how, double ms[RENDERER_STAGES],
                       struct error *err);

// The display picture of the samples so far: straight-alpha RGBA8, top row
// first, image.width x image.height, into *out (cleared first).  Before the
// first sample that of the draft, enlarged, where one was made.
bool renderer_read_display(struct renderer *r, struct buf *out,
                           struct error *err);
// The linear picture: float RGBA, premultiplied, A = coverage by hair; before
// view.*.  Same shape.
bool renderer_read_linear(struct renderer *r, struct buf *out,
                          struct error *err);

// The parts that the whole picture is the sum of: single_R, single_TT,
// single_TRT, global, local.
enum { RENDERER_LAYERS = 5 };
extern const char *const renderer_layer_names[RENDERER_LAYERS];
// From now on each sample makes them too, out of the same cells and shadows;
// the picture begins anew, the same bit for bit, but where tables light it: it
// adds up to its parts then, which are read mode by mode.  Fails when
// render.components is not all, which must stay so.  off: ends that and frees
// their memory (16 bytes for each cell and pixel); the picture stays, or, of
// tables, begins anew once more: true.
bool renderer_layers_on(struct renderer *r, struct error *err);
bool renderer_layers_off(struct renderer *r);
// As renderer_read_linear.  A part that this scene leaves out is black.
bool renderer_read_layer(struct renderer *r, int layer, struct buf *out,
                         struct error *err);

// The programs that are compiled, a line each, and one of another renderer's to
// be compiled ahead of its first use.
void renderer_programs(const struct renderer *r, struct buf *out);
bool renderer_prepare(struct renderer *r, struct span line, struct error *err);
// What warm_begin takes of what it renders (renderer/warm.h); after a step.
struct warm_scene;
void renderer_warm_scene(const struct renderer *r, struct warm_scene *out);

void renderer_stats(const struct renderer *r, struct renderer_stats *out);

#endif
