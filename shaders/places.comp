#version 450 core
// Cells as plain numbers, for who compares them with something else: where on
// the hair they are, as the shading has it, and their radiance.
#include "scene.glsl"
#include "cells.glsl"
#include "place.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint count;

struct Item {
    vec4 position; // xyz; w: along
    vec4 tangent;  // xyz; w: segment, as bits
    vec4 radiance;
};
layout(std430, binding = 2) readonly buffer Numbers { uint numbers[]; };
layout(std430, binding = 3) writeonly buffer Items { Item items[]; };

void main()
{
    uint at = gl_GlobalInvocationID.x;
    if (at >= count)
        return;
    Place c = place_of(list[numbers[at]]);
    items[at] = Item(vec4(c.p, c.along),
                     vec4(c.u, uintBitsToFloat(c.segment)),
                     radiance[numbers[at]]);
}
