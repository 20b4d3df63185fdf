// reference.h - the truth beside the picture, in double precision: light
// scattered once, and path tracing, over the strands themselves.
//
// The scene is the groom as shoot.h has it (ribbons that face the ray, the head
// black and opaque), the fibre of fibre.h, the sky as 128 x 64 texels of even
// radiance that hold the map's energy (the fit's own splat, turned by light.*,
// coloured by tint.*), suns as directions.  Nothing of the shaders, the SRBF
// lights or the shadow field is used, but where a flag asks for it.
// hair.use_colour tints the result once, at the visible place, as in the
// picture.
//
// Radiance of a ribbon = integral of S L cos theta_i d omega_i (METHODS, 8).
//
// Thread: any; every function uses all cores itself, a finished scene is
// immutable.  Results depend on the seed, never on the number of cores.
#ifndef RENDERER_REFERENCE_H
#define RENDERER_REFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/fibre.h"
#include "renderer/groom.h"
#include "renderer/places.h"
#include "renderer/sky.h"
#include "renderer/watch.h"

struct reference;

struct reference_scene { // borrowed for the call
    const struct groom *groom;
    const struct sky_map *map;
    const struct sky_fit *fit; // for REFERENCE_SRBF; NULL: not wanted
    const struct params *params;
    enum fibre_model model;
    struct watch *watch; // NULL, or cuts the making; no error is set then
};

// NULL when the groom is more than shoot.h takes.
struct reference *reference_create(const struct reference_scene *scene,
                                   struct error *err);
// Makes s what reference_create would, anew only in what differs: hair, fibre,
// sky (told apart by their contents).  False leaves it as it was.
bool reference_update(struct reference *s, const struct reference_scene *scene,
                      struct error *err);
// A renderer's present groom, sky, fit and parameters, by pointer; the model
// is the exact one.  Thread: render.
void renderer_scene(const struct renderer *r, struct reference_scene *out);
// Of a renderer's present groom, sky, fit and parameters.  Thread: render.
struct reference *renderer_reference(const struct renderer *r,
                                     enum fibre_model model, struct error *err);
bool renderer_reference_update(const struct renderer *r, enum fibre_model model,
                               struct reference *s, struct error *err);
void reference_destroy(struct reference *s);       // NULL is allowed
size_t reference_bytes(const struct reference *s); // memory of its hair
const struct fibre *reference_fibre(const struct reference *s);

// --- light scattered once ---------------------------------------------------

enum {                        // flags of all functions
    REFERENCE_UNSHADOWED = 1, // every place sees the whole sky
    // The renderer's SRBF lights instead of the texels: exact integrals
    // (exact.h), and by shadows the lobe's mean transmittance times them, as
    // the methods have it.  A tenth of a second a place.  FIBRE_EXACT only.
    REFERENCE_SRBF = 2,
};

struct reference_single {
    double mode[FIBRE_MODES][3]; // R, TT, TRT
    double sum[3];
    double seen; // of the sky's and the suns' light that matters here (where S
                 // is not nothing) the share that arrives unblocked
};

// Texel by texel, one jittered direction in each (several where the texel is
// bright or a lobe narrower than it): unbiased, and right to about .5 % at a
// place.  out[count].
void reference_single(const struct reference *s,
                      const struct places_item *place, size_t count,
                      unsigned flags, uint64_t seed,
                      struct reference_single *out);

// --- path tracing -----------------------------------------------------------

struct reference_progress {
    double share;        // done, 0..1
    double seconds_left; // estimated
    int samples;         // of each place or pixel so far
};

struct reference_paths { // zero is a sensible default but for samples
    int samples;         // paths a place or pixel; at least 1
    int events;          // at most so many scatterings; 0: no limit
    unsigned flags;
    uint64_t seed;
    // Called between rounds, on the caller's thread; false stops there, and
    // the results hold what is done.  NULL: not called.
    bool (*progress)(void *self, const struct reference_progress *p);
    void *self;
};

enum { REFERENCE_BOUNCES = 16 };

struct reference_estimate { // of one place
    int samples;
    double single[3], single_variance[3];     // lit directly; variance of the
    double multiple[3], multiple_variance[3]; // mean, not of a sample
    double whole[3], whole_variance[3];
    double bounce[REFERENCE_BOUNCES][3]; // by scatterings: [0] is single, the
                                         // last one holds all that follow
    double events;                       // mean number of scatterings a path
};

// Paths from the eye: directions drawn from the fibre and from the sky, both
// weighted by their densities (Veach and Guibas 1995, balance heuristic);
// Russian roulette.  The least noise for all light is had from
// reference_single's sum and `multiple`.  out[count].  False when progress
// stopped it.
bool reference_path(const struct reference *s, const struct places_item *place,
                    size_t count, const struct reference_paths *how,
                    struct reference_estimate *out);

// A whole picture as camera.* and image.* have it: rays through the pixels,
// each a ribbon or nothing.  rgba, variance: [4 * width * height], top row
// first; linear, premultiplied, A = coverage by hair; variance of the means.
// how->events = 1 gives light scattered once.  False with err when
// width x height is above REFERENCE_PIXELS_MAX, or that times the samples above
// REFERENCE_PATHS_MAX; a stop by progress is
// no error: *samples is how many were made.
#define REFERENCE_PATHS_MAX (1ull << 28)
#define REFERENCE_PIXELS_MAX (1 << 22)
bool reference_picture_fits(const struct params *p, int samples,
                            struct error *err);
bool reference_picture(const struct reference *s,
                       const struct reference_paths *how, float *rgba,
                       float *variance, int *samples, struct error *err);

#endif
