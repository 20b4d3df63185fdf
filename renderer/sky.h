// sky.h - a lat-long environment map, and the SRBF lights that stand for it.
//
// Direction (x, y, z), z up, of map coordinates u, v in [0, 1] (v from the top
// row): u = 0.5 - atan2(y, x) / (2 pi), v = 0.5 - asin(z) / pi.
// An SRBF light (Xu 2011, eq 1): L_j exp(2 (w . w_j - 1) / lambda_j^2).
// Thread: any; values only, no shared state.
#ifndef RENDERER_SKY_H
#define RENDERER_SKY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

enum { SKY_LIGHTS_MAX = 200 };

// What cleaning did to the pixels of a file.
struct sky_cleaned {
    uint64_t negative, nan, infinite; // colour values changed
    double energy_share; // energy changed / energy after, mean over channels
};

struct sky_map {   // linear Rec. 709 radiance, cleaned: finite and >= 0
    char name[64]; // file name without folders, or "builtin:studio"
    int width, height;
    float *rgb; // [3 * width * height], top row first
    struct sky_cleaned cleaned;
    unsigned char sha256[32]; // of the file's bytes; of the pixels if built in
};

// An OpenEXR (scan line or tiled, half or float, any compression) or Radiance
// file, told by its first bytes.  Decoded in a limited helper process: a
// hostile file costs at most 5 s and one error.  Deep, multipart and cube maps
// are refused by name; the rules are in docs/FORMATS.md.
// Thread: any; blocks.  It starts /proc/self/exe, which must stay executable.
struct sky_map *sky_load(const char *path, struct error *err);
struct sky_map *sky_builtin(const char *name, struct error *err); // "studio"
struct sky_map *sky_open(const char *source, struct error *err);  // either
extern const char *const sky_builtin_names[]; // NULL-terminated
void sky_map_destroy(struct sky_map *m);      // NULL is allowed

// Call first thing in main: when this process was started as the decoding
// helper of sky_load, does that work and exits; else returns at once.
void sky_helper_main(int argc, char **argv);

struct sky_light {
    double direction[3]; // unit, in the map's frame
    double lambda;       // Xu width
    double radiance[3];  // L_j, >= 0
};

enum sky_fit_mode { SKY_FIT_HAIR, SKY_FIT_PLAIN }; // order of sky.fit's words

struct sky_fit {
    int count;                              // may be below the number asked for
    struct sky_light light[SKY_LIGHTS_MAX]; // by falling energy
    double residual;        // f: relative weighted residual of the objective
    double predicted_error; // p90 of the shading error to expect: .85 f of the
                            // hair objective, in either mode
    double energy_ratio[3]; // lights / map per channel before scaling
    double seconds;         // of this fit; of the original one if from cache
    int iterations;
    bool from_cache;
};

// Fits `lights` (1..SKY_LIGHTS_MAX) SRBF lights.  Deterministic; blocks: 0.3 s
// for 40, 1 s for 80, 3 s for 200 lights.  A black map gives no lights.
// Widths: 0.02 to 2.2 / sqrt(lights), in the plain mode 0.05 to 4.  cache_dir:
// fits are kept there by content hash and settings; NULL keeps none; a cache
// that cannot be used is not an error.
bool sky_fit_run(const struct sky_map *map, int lights, enum sky_fit_mode mode,
                 const char *cache_dir, struct sky_fit *fit, struct error *err);
struct watch;
struct sky_fit_job {
    const struct sky_map *map;
    int lights;
    enum sky_fit_mode mode;
    const char *cache_dir;
    struct watch *watch; // NULL, or looked at between two steps
};
// The same; false, and *fit is nothing, as well where it was cut.
bool sky_fit_do(const struct sky_fit_job *job, struct sky_fit *fit,
                struct error *err);

// At most `lights` (1..) of a fit's lights, of the same energy in each channel:
// some are put together.  Where the fit has no more than that they are its own.
// Microseconds; not as near to the sky as a fit of so many.
void sky_fit_fewer(const struct sky_fit *from, int lights, struct sky_fit *out);

// Radiance of the lights' sum in a direction (unit), for pictures and tests.
void sky_fit_eval(const struct sky_fit *fit, const double direction[3],
                  double rgb[3]);

// Solid angle integral of one light's lobe: pi lambda^2 (1 - e^{-4/lambda^2}).
double sky_lobe_omega(double lambda);

#endif
