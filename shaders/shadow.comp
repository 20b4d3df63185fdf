#version 450 core
// What of each light reaches the places that the first sample sees, kept for
// the edits of fibre and light colour to come: they change none of it.
#include "scene.glsl"
#include "cells.glsl"
#include "shadow.glsl"
#include "place.glsl"
#include "nodes.glsl"
layout(local_size_x = 64) in;

void main()
{
    uint at = gl_GlobalInvocationID.x, light = gl_WorkGroupID.y;
    if (at >= list_end[0])
        return;
    Place c = place_of(list[at]);
    nodes[light * nodes_stride + at] =
        shadow_nodes(light, c.p, c.u, c.segment, c.key);
}
