#version 450 core
// From ids to cells: every pixel looks its cell up in the hash table, new cells
// are appended to the list of what is to be shaded.
#include "scene.glsl"
#include "cells.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform usampler2D ids;

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

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), extent = ivec2(size.xy);
    if (any(greaterThanEqual(pixel, extent)))
        return;
    uvec2 id = texelFetch(ids, pixel, 0).xy;
    uint to = id.x == ID_HEAD ? 1u : 0u;
    if (id.x >= ID_FIRST) {
        uint segment = id.x - ID_FIRST, n = cell_count(segment);
        uint cell = min(uint(uintBitsToFloat(id.y) * float(n)), n - 1u);
        to = slot_of((segment << CELL_BITS | cell) + 1u);
    }
    // rows bottom first in the raster, top first in everything after
    uint row = uint(extent.y - 1 - pixel.y);
    map[sample_index.w + row * uint(extent.x) + uint(pixel.x)] = to;
}
