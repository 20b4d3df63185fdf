#version 450 core
// The sparse samples of forward transmittance: fibres crossed along each
// light's centre, at the voxels of a coarse grid, as the field has them: sixteen
// lights a texel.  Invocations: a voxel, a bank.
#include "shadow.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) writeonly buffer Bytes { uvec4 words[]; };

void main()
{
    uvec3 size = uvec3(shadow_size.xyz);
    uint i = gl_GlobalInvocationID.x, bank = gl_WorkGroupID.y;
    if (i >= size.x * size.y * size.z)
        return;
    uvec3 v = uvec3(i % size.x, i / size.x % size.y, i / size.x / size.y);
    vec3 p = shadow_box.xyz + (vec3(v) + 0.5) / shadow_box.w;
    uvec4 word = uvec4(0u);
    for (uint k = 0u; k < 16u; k++) {
        // a way a light: every slot ends a run, or is no way's
        uint row = shadow_run[4u * bank + (k >> 2u)][k & 3u] & RUN_ROW;
        uint j = max(row, 1u) - 1u;
        // half a voxel, in cells
        float least = 0.5 / shadow_box.w * sqrt(shadow_frame[4u * j + 3u].w);
        float n = shadow_map_crossings(j, p, vec2(0.0), least);
        uint byte = max(uint(exp(-SHADOW_FALL * n) * 255.0 + 0.5), 1u);
        word[k >> 2u] |= byte << (8u * (k & 3u));
    }
    words[bank * shadow_all.w + i] = word;
}
