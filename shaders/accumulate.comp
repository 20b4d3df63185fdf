#version 450 core
// Adds a sample: premultiplied radiance and coverage of hair, and apart from it
// how often the head was seen.  LAYER: radiance and sum of a part of the
// picture are bound; coverage and head are the whole's affair.
#include "scene.glsl"
#include "cells.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 9) buffer Sum { vec4 sum[]; };
#ifndef LAYER
layout(std430, binding = 10) buffer Head { float head[]; };
#endif

void main()
{
    uint row = gl_NumWorkGroups.x * 64u;
    uint at = gl_GlobalInvocationID.x + gl_WorkGroupID.y * row;
    if (at >= uint(size.x) * uint(size.y))
        return;
    uint to = map[sample_index.w + at];
    bool first = sample_index.x == 0u;
    vec4 s = first ? vec4(0.0) : sum[at];
    if (to >= MAP_FIRST)
        s += vec4(radiance[to - MAP_FIRST].rgb, 1.0);
    sum[at] = s;
#ifndef LAYER
    float h = first ? 0.0 : head[at];
    head[at] = to >= MAP_FIRST ? h : h + float(to);
#endif
}
