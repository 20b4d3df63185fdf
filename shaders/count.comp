#version 450 core
// Closes a sample's part of the list and sizes the dispatches that work on it.
#include "cells.glsl"
layout(local_size_x = 1) in;
layout(location = 0) uniform uint kept;       // index of this sample's part
layout(location = 1) uniform uint close_part; // 1: the part ends at `listed`
layout(location = 2) uniform uint lights;

void main()
{
    if (close_part == 1u)
        list_end[kept] = listed;
    uint begin = kept > 0u ? list_end[kept - 1u] : 0u;
    shaded = list_end[kept] - begin;
    dispatch = uvec4((shaded + 63u) / 64u, 1u, 1u, begin);
    shadow_dispatch = uvec4((shaded + 63u) / 64u, max(lights, 1u), 1u, 0u);
}
