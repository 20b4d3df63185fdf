#version 450 core
// The sparse samples of forward transmittance: fibres crossed along each
// light's centre, at the voxels of a coarse grid, as bytes of the atlas's
// tiles.  Invocations: four voxels along x, a light.
#include "shadow.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec2 range; // lights; the first
layout(std430, binding = 2) writeonly buffer Bytes { uint words[]; };

void main()
{
    uvec3 size = uvec3(shadow_size.xyz);
    uint fours = size.x / 4u, all = fours * size.y * size.z;
    uint i = gl_GlobalInvocationID.x, j = gl_WorkGroupID.y;
    if (i >= all)
        return;
    uvec3 v = uvec3(i % fours * 4u, i / fours % size.y, i / fours / size.y);
    uint word = 0u;
    // half a voxel, in cells
    float least = 0.5 / shadow_box.w * sqrt(shadow_frame[4u * (range.y + j) + 3u].w);
    for (uint k = 0u; k < 4u; k++) {
        vec3 g = vec3(v) + vec3(k, 0, 0) + 0.5;
        vec3 p = shadow_box.xyz + g / shadow_box.w;
        float n = shadow_map_crossings(range.y + j, p, vec2(0.0), least);
        uint byte = max(uint(exp(-SHADOW_FALL * n) * 255.0 + 0.5), 1u);
        word |= byte << (8u * k);
    }
    words[j * all + i] = word;
}
