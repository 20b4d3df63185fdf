#version 450 core
// What the raster begins with where the head may be: an ellipsoid.  Strands
// grow from it, and what it hides need not be looked at again.
#include "raster.glsl"
#include "raster_work.glsl"
#include "cells.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(location = 1) uniform uvec4 window; // first column and row, how many

// near / depth where the pixel's ray meets the head, 0 where it does not.
float head_seen(vec2 pixel)
{
    vec2 at = pixel / size.xy * 2.0 - 1.0 - jitter.xy;
    vec3 ray = forward.xyz + at.x * right.xyz + at.y * up.xyz;
    vec3 o = (eye.xyz - head_centre.xyz) / head_radius.xyz;
    vec3 d = ray / head_radius.xyz;
    // to where the ray is nearest to the centre, and from there
    float dd = dot(d, d), middle = -dot(o, d) / dd;
    vec3 m = o + middle * d;
    float h = 1.0 - dot(m, m);
    if (h <= 0.0)
        return 0.0;
    float half_way = sqrt(h / dd);
    float t = middle - half_way;
    if (t < size.w)
        t = middle + half_way; // the eye is inside
    return t < size.w ? 0.0 : size.w / t;
}

void main()
{
    uvec2 n = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(n, window.zw)))
        return;
    uvec2 pixel = n + window.xy;
    float depth = head_seen(vec2(pixel) + 0.5);
    if (depth <= 0.0)
        return;
    depth_seen[pixel.y * uint(size.x) + pixel.x] = floatBitsToUint(depth);
    map[map_place(pixel)] = 1u;
}
