#version 450 core
// A sample's map from slots to numbers, once all cells have theirs.  As in
// accumulate.comp an invocation finds those of its pixels that ask for work first.
#include "scene.glsl"
#include "cells.glsl"
#include "spread.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 11) readonly buffer Numbers { uint numbers[]; }; // by slot

const uint ROWS = 8u; // of 64 pixels: picture.h has PICTURE_GROUP_PIXELS of both

void main()
{
    uint pixels = uint(size.x) * uint(size.y);
    uint from = spread_piece() * (64u * ROWS) + gl_LocalInvocationID.x;
    if (from >= pixels)
        return;
    uint rows = min(ROWS, (pixels - from + 63u) / 64u), hair = 0u;
    from += sample_index.w;
    for (uint i = 0u; i < rows; i++)
        hair |= map[from + 64u * i] >= MAP_FIRST ? 1u << i : 0u;
    while (hair != 0u) {
        uint at = from + 64u * uint(findLSB(hair));
        hair &= hair - 1u;
        map[at] = MAP_FIRST + numbers[map[at] - MAP_FIRST];
    }
}
