#version 450 core
// Groups of segments of which something may be seen in this sample: before the
// eye, within the picture, of a strand that is kept.  `bounds` are spheres
// around their points.  Both rasters decide for each segment anew; here nothing
// may be lost, hence the margins.
#include "raster.glsl"
#include "keep.glsl"
#include "raster_work.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) readonly buffer Bounds { vec4 bounds[]; };
layout(location = 1) uniform uint groups;
layout(location = 2) uniform vec2 diameters; // smallest and largest, world

void main()
{
    uint n = gl_GlobalInvocationID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x *
                                           64u;
    if (n >= groups)
        return;
    vec4 s = bounds[n];
    vec3 c = clip_of(s.xyz).xyw;
    float nearest = max(c.z - s.w, size.w), farthest = c.z + s.w;
    // two pixels more: a line's own width, and the jitter
    float r = s.w + 0.5 * diameters.y + 2.0 * farthest / size.z;
    vec2 slope = vec2(inversesqrt(dot(right.xyz, right.xyz)),
                      inversesqrt(dot(up.xyz, up.xyz)));
    vec2 over = abs(c.xy) - c.z - r * sqrt(1.0 + slope * slope);
    bool out_of_view = s.w < 0.0 || farthest <= size.w || over.x > 0.0 ||
                       over.y > 0.0;
    vec2 pixels = diameters * size.z / vec2(farthest, nearest);
    // of how many samples is it, at most?  A line's slope makes up to sqrt 2.
    float share = min(1.43 * pixels.y, 1.0);
#ifndef WITH_OPACITY
    share *= hair_colour.w;
#endif
    uint last = min(n * RASTER_GROUP + RASTER_GROUP, sample_index.y) - 1u;
    uint a = strand_of[n * RASTER_GROUP], b = strand_of[last];
    bool kept = b - a > 1u || keep_draw(a, sample_index.x) < share ||
                keep_draw(b, sample_index.x) < share;
    if (out_of_view || !kept)
        return;
    if (pixels.x < 1.01 * THIN_BELOW)
        list_entry(GROUPS, n, RASTER_GROUP);
    if (pixels.y > 0.99 * THIN_BELOW)
        list_entry(GROUPS + 1u, n, RASTER_GROUP);
}
