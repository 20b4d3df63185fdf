#version 450 core
// accumulate.comp for what the forward passes drew.
#include "scene.glsl"
#include "seen.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 9) buffer Sum { vec4 sum[]; };
layout(std430, binding = 10) buffer Seen { uint seen[]; };
layout(binding = 14) uniform usampler2D ids;
layout(binding = 15) uniform sampler2D drawn;

void main()
{
    uint row = gl_NumWorkGroups.x * 64u;
    uint at = gl_GlobalInvocationID.x + gl_WorkGroupID.y * row;
    uint wide = uint(size.x), high = uint(size.y);
    if (at >= wide * high)
        return;
    // rows bottom first in the raster, top first in everything after
    ivec2 pixel = ivec2(at % wide, high - 1u - at / wide);
    bool first = sample_index.x == 0u;
    vec4 s = first ? vec4(0.0) : sum[at];
    uint before = first ? 0u : seen[at];
    vec4 more = texelFetch(drawn, pixel, 0);
    bool of_head = texelFetch(ids, pixel, 0).x == ID_HEAD;
    sum[at] = s + more;
    seen[at] = before + (more.a > 0.0 ? SEEN_HAIR : of_head ? SEEN_HEAD : 0u);
}
