// shading.h - the program that shades cells: which variant a scene needs, its
// uniforms and tables, and what was left out of it and why.
// Thread: render.
#ifndef RENDERER_SHADING_H
#define RENDERER_SHADING_H

#include <stdbool.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/best_lobes.h"
#include "renderer/dual_tables.h"
#include "renderer/fast_tables.h"
#include "renderer/lights.h"
#include "renderer/lit_tables.h"
#include "renderer/nodes.h"
#include "renderer/strands.h"
#include "renderer/xu_tables.h"

enum { SHADING_VARIANTS = 16, SHADING_DEFINES = 192 };

struct shading_variant {
    char defines[SHADING_DEFINES];
    unsigned program;
    unsigned age; // the oldest gives way
};

struct shading {
    struct shading_variant variant[SHADING_VARIANTS];
    char base[SHADING_DEFINES]; // what the parameters ask for
    unsigned clock;
    unsigned params;          // uniform block
    struct xu_tables *tables; // NULL unless a part has scheme `paper`
    struct best_lobes *lobes; // made when scheme `best` is first asked for
    int m; // segments, where the program has them as a uniform
    struct dual_tables *dual; // made when it is first asked for
    struct fast_tables *fast; // the same
    struct lit_tables *lit;   // the same
    const char *refused;      // why tables were asked for in vain, or NULL
    bool circular, opaque, shadowed, multiple;
    bool tabled;         // render.path=table, and the tables hold
    bool best;           // single scattering by scheme `best`
    double opaque_bound; // what leaving TT and TRT out can change, of R
    float mask[3];       // R, TT, TRT shown
    float share[2];      // global, local multiple scattering shown
    bool adds_up;        // what is shown is a sum over lights
    bool whole;          // ... of all that there is
};

void shading_init(struct shading *s);
void shading_finish(struct shading *s);

// Decides what the parameters ask of the program, uploads the parameter block
// and tables.  shadowed: transmittances are to be had.
void shading_update(struct shading *s, const struct params *p,
                    const struct strands *strands, bool shadowed);
// Another word of render.components, whatever *p says; what shading_update made
// for `all` holds what it needs.
void shading_show(struct shading *s, const struct params *p,
                  const struct strands *strands, int components);
bool shading_wants_axis(const struct params *p);
// Is what is shown a sum over lights, each times its radiance?
bool shading_adds_up(const struct params *p);

struct shading_sample {
    int part; // of the list of cells, as picture_prepare had it
    const struct nodes_store *nodes; // transmittances; NULL: looked up here
    uint32_t from;                   // the first cell of that part
    // Where all modes may be read from tables of each light (lit_tables.h): the
    // lights, and the picture whose places are shaded.  NULL: mode by mode.
    const struct lights *lights;
    uint64_t lit_bytes; // that these tables may take, and again their records
    float lit_spread;   // quality.group_deg, rad
    const struct picture *picture;
    bool again;    // the same places as ever since shading_forget,
    unsigned made; // in the order of these transmittances (nodes.h)
};

// The places that a first sample sees, or what of the lights reaches them, have
// changed.
void shading_forget(struct shading *s);

// Binds program (compiled when it is new), block, tables and strands for
// picture_dispatch.
bool shading_bind(struct shading *s, const struct strands *strands,
                  const struct shading_sample *how, struct error *err);

// For another program that includes shade.glsl: what to define (nodes: NULL
// where transmittances are looked up), and, once it is made, all that
// shading_bind binds and sets but the program itself and the list's part.
void shading_defines(const struct shading *s, const struct nodes_store *nodes,
                     char out[SHADING_DEFINES]);
void shading_bind_inputs(struct shading *s, unsigned program,
                         const struct strands *strands,
                         const struct nodes_store *nodes);

#endif
