// reference_private.h - what is behind a struct reference.  For reference*.c
// only.
// Thread: any; immutable once made.
#ifndef RENDERER_REFERENCE_PRIVATE_H
#define RENDERER_REFERENCE_PRIVATE_H

#include "renderer/lights.h"
#include "renderer/reference.h"
#include "renderer/shoot.h"

enum {
    REFERENCE_WIDTH = 128, // texels of the sky
    REFERENCE_HEIGHT = 64,
    REFERENCE_TEXELS = REFERENCE_WIDTH * REFERENCE_HEIGHT
};

struct reference_sky {
    // texel -> world, row-major, and its inverse, the transpose
    double to_world[9];
    double radiance[REFERENCE_TEXELS][3];
    double omega[REFERENCE_HEIGHT];  // solid angle of a row's texels
    double chance[REFERENCE_TEXELS]; // of being drawn, by energy
    double before[REFERENCE_TEXELS]; // sum of the chances
    double energy[3];                // Int L d omega
    bool black;
    struct lights_sun sun[LIGHTS_SUNS];
    int suns;
};

struct reference {
    struct params params;
    struct shoot *shoot;
    size_t hair_bytes;
    struct fibre *fibre;
    struct reference_sky sky;
    uint64_t hair_key;
    unsigned char sky_key[32];
    bool sky_made;
    bool elliptic;   // the fibre: `axis` counts
    float *tangent;  // [3 * points] as the shading has them
    uint32_t *axis;  // [points], or NULL: not needed yet
    float *colour;   // [3 * points], or NULL
    double plain[3]; // colour where there is no array
    float box_min[3], box_max[3];
    int lights; // SRBF, world, for REFERENCE_SRBF
    struct sky_light *light;
};

// --- random numbers: a stream is told by two numbers, whoever draws ---------
struct reference_random {
    uint64_t state;
};
void reference_random_begin(struct reference_random *r, uint64_t seed,
                            uint64_t a, uint64_t b);
double reference_random_next(struct reference_random *r); // [0, 1)

// --- sky --------------------------------------------------------------------
void reference_sky_make(struct reference_sky *s, const struct sky_map *map,
                        const struct params *p);
// A direction of the texel's own, u and v in [0, 1): even in solid angle.
void reference_sky_direction(const struct reference_sky *s, int texel, double u,
                             double v, double out[3]);
int reference_sky_texel(const struct reference_sky *s, const double d[3]);
// The texel that a number of [0, 1) falls on.
int reference_sky_draw(const struct reference_sky *s, double u);

// --- a place and its frame --------------------------------------------------
struct reference_vertex {
    double position[3];
    double u[3], v[3], w[3];
    uint32_t segment;
    double along;
    struct fibre_direction eye; // where the light goes
};
// Where a ray met the hair; to_eye: away from it, along the ray.
void reference_vertex_of(const struct reference *s, uint32_t segment,
                         double along, const double to_eye[3],
                         struct reference_vertex *out);
void reference_vertex_at(const struct reference *s,
                         const struct places_item *place,
                         struct reference_vertex *out);
// v of a place: the strands' axis (NULL: none is wanted), or towards the eye.
void reference_vertex_across(const uint32_t *axis, const struct places_item *p,
                             double v[3]);
void reference_vertex_colour(const struct reference *s,
                             const struct reference_vertex *v, double rgb[3]);
struct fibre_direction reference_vertex_in(const struct reference_vertex *v,
                                           const double d[3]);
void reference_vertex_out(const struct reference_vertex *v,
                          const struct fibre_direction *i, double d[3]);

// The ray goes on behind the segment that it met after t: behind all that is
// met there within rounding.
void reference_ray_past(struct shoot_ray *ray, uint32_t segment, double t);

// One path from a vertex.
struct reference_walk {
    const struct reference *scene;
    unsigned flags;
    int events; // at most; 0: no limit
    struct reference_random random;
    double bounce[REFERENCE_BOUNCES][3]; // result
    int length;                          // result: scatterings
};
void reference_walk_run(struct reference_walk *w,
                        const struct reference_vertex *from);

#endif
