#version 450 core
// Radiance of the cells that this sample sees for the first time.
#include "shade.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint kept;
layout(location = 5) uniform uint from; // of these cells, by this dispatch

void main()
{
    uint row = gl_NumWorkGroups.x * 64u;
    // within this sample's part
    uint at = from + gl_GlobalInvocationID.x + gl_WorkGroupID.y * row;
    uint entry = dispatch.w + at;
#ifdef SHADOW_STORED // or as much of it as there are transmittances
    if (at >= nodes_stride)
        return;
    entry += nodes_begin;
#endif
#ifdef LIT_KEPT
    entry -= at;
    at = lit_unsorted(at);
    entry += at;
#endif
    if (entry >= list_end[kept])
        return;
    vec3 seen = shade_seen(place_of(list[entry]), at, 0u, light_count);
    radiance[entry] = vec4(seen, 1.0);
}
