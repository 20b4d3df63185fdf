#version 450 core
// From ids to cells: every pixel that sees hair looks its cell up in the hash
// table, new cells are appended to the list of what is to be shaded.  The map
// has been cleared, and says where the head is.  It gets slots: who finds a cell
// that another thread just put there cannot know its number yet
// (cells_number.comp).
#include "raster.glsl"
#include "cells.glsl"
#ifdef DRAWN // by visible.frag
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform usampler2D ids;
#else
#include "raster_work.glsl"
layout(local_size_x = 64) in;
#endif

layout(std430, binding = 11) writeonly buffer Numbers { uint numbers[]; }; // by slot

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
                uint number = atomicAdd(listed, 1u);
                list[number] = key;
                numbers[at] = number;
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
    map[map_place(uvec2(pixel))] = to;
}
#else
void main()
{
    uint n = gl_GlobalInvocationID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x *
                                           64u;
    if (n >= work[PIXELS].w)
        return;
    uint at = entry[entry_of(PIXELS, n)], segment = seen_id[at];
    uvec2 pixel = uvec2(at % uint(size.x), at / uint(size.x));
    Lie l = lie_of(segment);
    float s = foot_of(l, way_of(l), vec2(pixel) + 0.5);
    float along = along_of(l, s, depth_of(l, s));
    uint cells = cells_between(vec4(l.p0.xy, 0.0, l.p0.z),
                               vec4(l.p1.xy, 0.0, l.p1.z));
    uint cell = min(uint(along * float(cells)), cells - 1u);
    map[map_place(pixel)] = slot_of((segment << CELL_BITS | cell) + 1u);
}
#endif
