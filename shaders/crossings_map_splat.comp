#version 450 core
// Puts every segment into every light's optical depth map: area across the
// light over the area of a cell, in whole 65536ths, so that the sum does not
// depend on the order of threads.  Invocations: a segment, a light.
#include "shadow.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec2 range; // points; the first light
layout(std430, binding = 0) readonly buffer Points { vec4 points[]; };
#ifdef WITH_OPACITY
layout(std430, binding = 1) readonly buffer Opacity { float opacity_of[]; };
#endif
layout(std430, binding = 2) buffer Cells { uint cells[]; };
const float UNIT = 65536.0;

void main()
{
    uint i = gl_GlobalInvocationID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u;
    uint j = gl_WorkGroupID.z;
    if (i + 1u >= range.x || points[i].w < 0.0)
        return;
    uint f = 4u * (range.y + j), side = uint(shadow_map_size.x) + 1u;
    uint layers = uint(shadow_map_size.w);
    vec4 a = points[i], b = points[i + 1u];
    mat3x4 rows = mat3x4(shadow_frame[f], shadow_frame[f + 1u],
                         shadow_frame[f + 2u]);
    vec3 from = vec4(a.xyz, 1.0) * rows, to = vec4(b.xyz, 1.0) * rows;
    vec3 e = b.xyz - a.xyz, w = shadow_centre[range.y + j].xyz;
    e -= dot(e, w) * w;
    vec3 d = abs(to - from);
    // pieces of half a cell, or of half a layer
    int pieces = 1 + int(2.0 * min(max(max(d.x, d.y), d.z), 1e4));
    float area = UNIT * length(e) * shadow_frame[f + 3u].w / float(pieces);
    for (int n = 0; n < pieces; n++) {
        float t = (float(n) + 0.5) / float(pieces);
        float weight = area * mix(a.w, abs(b.w), t);
#ifdef WITH_OPACITY
        weight *= mix(opacity_of[i], opacity_of[i + 1u], t);
#else
        weight *= shadow_texel.w;
#endif
        ivec3 c = ivec3(mix(from, to, t));
        c = clamp(c, ivec3(0), ivec3(uvec3(uvec2(side - 2u), layers - 1u)));
        uint slice = j * layers + uint(c.z);
        // row and column 0 are the table's zeros
        atomicAdd(cells[(slice * side + uint(c.y) + 1u) * side + uint(c.x) + 1u],
                  uint(weight + 0.5));
    }
}
