#version 450 core
// Adds a sample: premultiplied radiance and coverage of hair, and apart from it
// how often hair and the head were seen.  LAYER: radiance and sum of a part of the
// picture are bound; what was seen is the whole's affair.
// Most pixels see no hair, and what they saw is there already: an invocation finds
// those of its pixels that ask for work, then does these.  (A renderer on a CPU
// runs both sides of a branch, and a loop's body as often as the busiest of a few
// neighbours wants it, once at least.)
#include "scene.glsl"
#include "cells.glsl"
#include "seen.glsl"
#include "spread.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 9) buffer Sum { vec4 sum[]; };
#ifndef LAYER
layout(std430, binding = 10) buffer Seen { uint seen[]; };
#endif

const uint ROWS = 8u; // of 64 pixels: picture.h has PICTURE_GROUP_PIXELS of both

void main()
{
    uint pixels = uint(size.x) * uint(size.y);
    uint from = spread_piece() * (64u * ROWS) + gl_LocalInvocationID.x;
    if (from >= pixels)
        return;
    uint rows = min(ROWS, (pixels - from + 63u) / 64u), first_map = sample_index.w;
    bool first = sample_index.x == 0u;
    uint hair = 0u; // rows, a bit each: those whose sum is another
#ifdef LAYER
    for (uint i = 0u; i < rows; i++)
        hair |= first || map[first_map + from + 64u * i] >= MAP_FIRST ? 1u << i : 0u;
#else
    uint other = 0u; // ... and those that saw something else than is written
    for (uint i = 0u; i < rows; i++) {
        uint at = from + 64u * i, to = map[first_map + at], before = seen[at];
        uint now = (first ? 0u : before) + (to >= MAP_FIRST ? SEEN_HAIR : to);
        other |= now != before ? 1u << i : 0u;
        bool zero = first && before >= SEEN_HAIR;
        hair |= zero || to >= MAP_FIRST ? 1u << i : 0u;
    }
    while (other != 0u) {
        uint at = from + 64u * uint(findLSB(other)), to = map[first_map + at];
        other &= other - 1u;
        seen[at] = (first ? 0u : seen[at]) + (to >= MAP_FIRST ? SEEN_HAIR : to);
    }
#endif
    while (hair != 0u) {
        uint at = from + 64u * uint(findLSB(hair)), to = map[first_map + at];
        hair &= hair - 1u;
        vec4 s = vec4(0.0);
        if (!first)
            s = sum[at];
        if (to >= MAP_FIRST)
            s += vec4(radiance[to - MAP_FIRST].rgb, 1.0);
        sum[at] = s;
    }
}
