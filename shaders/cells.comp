#version 450 core
// From ids to cells: every pixel looks its cell up in the hash table, new cells
// are appended to the list of what is to be shaded.
#include "raster.glsl"
#include "cells.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#ifdef DRAWN // by visible.frag
layout(binding = 0) uniform usampler2D ids;
#else
layout(std430, binding = 14) readonly buffer Seen { uint seen_id[]; };
#endif

uint hashed(uint x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15);
}

uint slot_of(uint key)
{
    uint at = hashed(key) & sample_index.z;
    for (uint tries = 0u; tries < 1024u; tries++) {
        uint was = keys[at];
        if (was == 0u) {
            was = atomicCompSwap(keys[at], 0u, key);
            if (was == 0u) {
                list[atomicAdd(listed, 1u)] = at;
                return MAP_FIRST + at;
            }
        }
        if (was == key)
            return MAP_FIRST + at;
        at = (at + 1u) & sample_index.z;
    }
    atomicAdd(lost, 1u);
    return 0u;
}

#ifdef DRAWN
uint seen(ivec2 pixel)
{
    uvec2 id = texelFetch(ids, pixel, 0).xy;
    if (id.x < ID_FIRST)
        return id.x == ID_HEAD ? 1u : 0u;
    uint segment = id.x - ID_FIRST, n = cell_count(segment);
    uint cell = min(uint(uintBitsToFloat(id.y) * float(n)), n - 1u);
    return slot_of((segment << CELL_BITS | cell) + 1u);
}
#else
uint key_of(uint segment, ivec2 pixel)
{
    Lie l = lie_of(segment);
    float s = foot_of(l, way_of(l), vec2(pixel) + 0.5);
    float along = along_of(l, s, depth_of(l, s));
    uint n = cells_between(vec4(l.p0.xy, 0.0, l.p0.z),
                           vec4(l.p1.xy, 0.0, l.p1.z));
    return (segment << CELL_BITS | min(uint(along * float(n)), n - 1u)) + 1u;
}

uint seen(ivec2 pixel)
{
    uint id = seen_id[uint(pixel.y) * uint(size.x) + uint(pixel.x)];
    if (id >= RASTER_HEAD)
        return id == RASTER_HEAD ? 1u : 0u;
    return slot_of(key_of(id, pixel));
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), extent = ivec2(size.xy);
    if (any(greaterThanEqual(pixel, extent)))
        return;
    // rows bottom first in the raster, top first in everything after
    uint row = uint(extent.y - 1 - pixel.y);
    map[sample_index.w + row * uint(extent.x) + uint(pixel.x)] = seen(pixel);
}
