#version 450 core
// Numbers the pixels that see hair, so that what is kept for each takes no room
// for the others: list[] from number to pixel, map[] from pixel to number.
#include "scene.glsl"
#include "cells.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 14) uniform usampler2D ids;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), extent = ivec2(size.xy);
    if (any(greaterThanEqual(pixel, extent)))
        return;
    if (texelFetch(ids, pixel, 0).x < ID_FIRST)
        return;
    uint number = atomicAdd(listed, 1u);
    list[number] = uint(pixel.y) * uint(extent.x) + uint(pixel.x);
    uint row = uint(extent.y - 1 - pixel.y);
    map[sample_index.w + row * uint(extent.x) + uint(pixel.x)] =
        MAP_FIRST + number;
}
