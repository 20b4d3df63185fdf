#version 450 core
// The sparse samples of forward transmittance: fibres crossed along each
// light's centre, at the voxels of a coarse grid, as the atlas's tiles have it:
// four lights a word.  Invocations: a voxel, a tile.
#include "shadow.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec2 range; // tiles; the first
layout(std430, binding = 2) writeonly buffer Bytes { uint words[]; };

void main()
{
    uvec3 size = uvec3(shadow_size.xyz);
    uint all = size.x * size.y * size.z;
    uint i = gl_GlobalInvocationID.x, tile = gl_WorkGroupID.y;
    if (i >= all)
        return;
    uvec3 v = uvec3(i % size.x, i / size.x % size.y, i / size.x / size.y);
    vec3 p = shadow_box.xyz + (vec3(v) + 0.5) / shadow_box.w;
    uint word = 0u;
    for (uint k = 0u; k < 4u; k++) {
        // a way a light: every slot ends a run, or is no way's
        uint row = shadow_run[range.y + tile][k] & RUN_ROW;
        uint j = max(row, 1u) - 1u;
        // half a voxel, in cells
        float least = 0.5 / shadow_box.w * sqrt(shadow_frame[4u * j + 3u].w);
        float n = shadow_map_crossings(j, p, vec2(0.0), least);
        uint byte = max(uint(exp(-SHADOW_FALL * n) * 255.0 + 0.5), 1u);
        word |= byte << (8u * k);
    }
    words[tile * all + i] = word;
}
