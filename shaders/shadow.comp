#version 450 core
// What of each light reaches the places that a sample sees first: all lights an
// invocation, or one where a light takes long (EACH).  The first sample's are
// kept for the edits of fibre and light colour to come, which change none of it.
#if defined SHADOW_RAYS || defined SHADOW_MAP
#define EACH
#endif
#include "scene.glsl"
#include "cells.glsl"
#include "shadow.glsl"
#include "place.glsl"
#define NODES_WRITTEN
#include "nodes.glsl"
#ifdef BY_PIXEL
#include "fragment.glsl"
#endif
layout(local_size_x = 64) in;
layout(location = 0) uniform uint kept;
layout(location = 5) uniform uint from; // of these places, by this dispatch
#ifdef SHADOW_RAYS
layout(location = 3) uniform uint rays;
#endif

#ifndef EACH
// A slot more in the sum of its run, which is kept where it ends.
vec4 add_slot(ShadowPlace s, uint slot, float q, uint run, vec4 sum, uint i)
{
    sum += shadow_slot_nodes(s, slot, q);
    if ((run & RUN_ROW) != 0u) {
        uint at = ((run & RUN_ROW) - 1u) * nodes_stride + i;
        uvec2 bits = shadow_run_bits(sum, run);
        if ((run & RUN_AGAIN) != 0u)
            bits += nodes[at];
        nodes[at] = bits;
    }
    return (run & RUN_END) != 0u ? vec4(0.0) : sum;
}

// The four slots of a word of the bank at hand.
#define ADD_WORD(WORD, NUMBER)                                                 \
    {                                                                          \
        uint t = 4u * bank + NUMBER;                                           \
        uvec4 run = shadow_run[t];                                             \
        uvec4 low = uvec4(b.low[0].WORD, b.low[1].WORD, b.low[2].WORD,         \
                          b.low[3].WORD);                                      \
        uvec4 high = uvec4(b.high[0].WORD, b.high[1].WORD, b.high[2].WORD,     \
                           b.high[3].WORD);                                    \
        sum = add_slot(s, 4u * t, shadow_mixed(corner, low, high, 0u), run.x,  \
                       sum, i);                                                \
        sum = add_slot(s, 4u * t + 1u, shadow_mixed(corner, low, high, 1u),    \
                       run.y, sum, i);                                         \
        sum = add_slot(s, 4u * t + 2u, shadow_mixed(corner, low, high, 2u),    \
                       run.z, sum, i);                                         \
        sum = add_slot(s, 4u * t + 3u, shadow_mixed(corner, low, high, 3u),    \
                       run.w, sum, i);                                         \
    }
#endif

void main()
{
    uint row = gl_NumWorkGroups.x * 64u;
    uint i = from + gl_GlobalInvocationID.x + gl_WorkGroupID.z * row;
    uint at = dispatch.w + nodes_begin + i;
#ifdef EACH
    uint light = gl_WorkGroupID.y;
#endif
    if (i >= nodes_stride || at >= list_end[kept])
        return;
#ifdef BY_PIXEL
    uint pixel = list[at], wide = uint(size.x);
    Place c = place_of_id(texelFetch(ids, ivec2(pixel % wide, pixel / wide), 0)
                              .xy);
#else
    Place c = place_of(list[at]);
#endif
#ifdef EACH
#ifdef SHADOW_RAYS
    uvec2 g = shadow_nodes_rays(light, c.p, c.u, c.segment, c.key, rays);
#else
    uvec2 g = shadow_nodes(light, c.p, c.u, c.segment, c.key);
#endif
    nodes[light * nodes_stride + i] = g;
#else
    ShadowPlace s = shadow_place(c.p);
    vec4 sum = vec4(0.0);
    ShadowCorner corner = shadow_corner(s.g);
    for (uint bank = 0u; bank < shadow_all.x; bank++) {
        ShadowBank b = shadow_bank(corner, bank);
        ADD_WORD(x, 0u)
        ADD_WORD(y, 1u)
        ADD_WORD(z, 2u)
        ADD_WORD(w, 3u)
    }
#endif
}
