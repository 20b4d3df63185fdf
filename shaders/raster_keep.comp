#version 450 core
// Groups of segments of which something may be seen in this sample: before the
// eye, within the picture, of a strand that is kept.  `bounds` are boxes
// around their points.  Both rasters decide for each segment anew; here nothing
// may be lost, hence the margins.
#include "raster.glsl"
#include "keep.glsl"
#include "raster_work.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) readonly buffer Bounds { float bounds[]; };
layout(location = 1) uniform uint groups;
layout(location = 2) uniform vec2 diameters; // smallest and largest, world

// A row of the way to clip space.
vec3 row_of(int i)
{
    return vec3(view_proj[0][i], view_proj[1][i], view_proj[2][i]);
}

void main()
{
    uint n = gl_GlobalInvocationID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x *
                                           64u;
    if (n >= groups)
        return;
    vec3 middle = vec3(bounds[6u * n], bounds[6u * n + 1u],
                       bounds[6u * n + 2u]);
    vec3 side = vec3(bounds[6u * n + 3u], bounds[6u * n + 4u],
                     bounds[6u * n + 5u]);
    vec3 c = clip_of(middle).xyw;
    vec3 x = row_of(0), y = row_of(1), w = row_of(3);
    float deep = dot(abs(w), side);
    float nearest = max(c.z - deep, size.w), farthest = c.z + deep;
    // two pixels more: a line's own width, and the jitter
    float wider = 0.5 * diameters.y + 2.0 * farthest / size.z;
    // how far inside of the picture's four sides is what is farthest inside?
    vec4 in_view = vec4(c.z - c.x + dot(abs(w - x), side),
                        c.z + c.x + dot(abs(w + x), side),
                        c.z - c.y + dot(abs(w - y), side),
                        c.z + c.y + dot(abs(w + y), side));
    vec4 more = wider * vec4(length(w - x), length(w + x), length(w - y),
                             length(w + y));
    bool out_of_view = side.x < 0.0 || farthest <= size.w ||
                       any(lessThan(in_view, -more));
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
