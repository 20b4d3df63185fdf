// crossings_probe.h - runs the renderer's own GLSL of shadows over arrays of
// points, for tests and benchmarks.
// Thread: render.
#ifndef RENDERER_CROSSINGS_PROBE_H
#define RENDERER_CROSSINGS_PROBE_H

#include "renderer/crossings.h"

struct crossings_place { // std430
    float p[3];          // world
    uint32_t segment;    // on which it lies
    float u[3];          // unit tangent
    uint32_t key;        // seeds the rays
};

struct crossings_result {           // std430
    uint32_t nodes[2];              // as shadow_nodes packs them
    float clear;                    // T~
    uint32_t guards;                // word 2 of those of probe.h, if asked for
    float forward[4], crossings[4]; // for each attenuation
};

struct crossings_probe_run {
    struct crossings *crossings;   // with directions for the lights
    const struct strands *strands; // needed for rays
    int rays;         // a light (crossings_build_lists); 0: the voxels alone
    bool note_guards; // see shaders/guard.glsl
    bool given_nodes; // places hold packed nodes in the bits of p[0] and p[1]
    float attenuation[4];
};

// results[count * lights], the lights of a place side by side.  At most what a
// storage buffer holds.
bool crossings_probe(const struct crossings_probe_run *run,
                     const struct crossings_place *places, int count,
                     int lights, struct crossings_result *results,
                     struct error *err);

#endif
