#version 450 core
// Strands to the raster, without vertex attributes: a segment is read from the
// points' buffer.  THIN draws lines and leaves wide segments to WIDE, which
// draws camera-facing quads; both decide by the same number.
#include "scene.glsl"
#include "keep.glsl"

#ifdef WITH_OPACITY
layout(std430, binding = 12) readonly buffer Opacity { float opacity_of[]; };
float opacity_at(uint i) { return opacity_of[i]; }
#else
float opacity_at(uint i) { return hair_colour.w; }
#endif

// The forward passes (forward.frag) meet the depths that the ids were drawn with.
invariant gl_Position;
out float along;         // 0..1 on the segment
out float keep;          // share of the samples that keep the fragment
flat out float drawn;    // this strand's number in this sample: kept if below
flat out uint segment;

// A line covers one pixel across its minor axis; below this width a strand's
// share stays under 1 for every slope.
const float THIN_BELOW = 0.7;

void main()
{
#ifdef WIDE
    uint i = uint(gl_VertexID) >> 2; // four corners a segment
    bool end = (gl_VertexID & 2) != 0;
    float side = (gl_VertexID & 1) != 0 ? 1.0 : -1.0;
#else
    uint i = uint(gl_VertexID) >> 1;
    bool end = (gl_VertexID & 1) == 1;
#endif
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // clipped away
    along = end ? 1.0 : 0.0;
    keep = 0.0;
    segment = i;
    drawn = keep_draw(strand_of[i], sample_index.x);
#ifndef WIDE
    if (drawn >= jitter.z)
        return; // no strand of this groom is wide enough to be kept
#endif
    vec4 p0 = points[i];
    if (p0.w < 0.0)
        return; // a strand's last point begins no segment
    vec4 p1 = points[i + 1u];
    vec4 c0 = clip_of(p0.xyz), c1 = clip_of(p1.xyz);
    if (max(c0.w, c1.w) <= size.w)
        return; // behind the eye
    vec2 d = vec2(p0.w, abs(p1.w));
    float middle = (d.x + d.y) * size.z / max(c0.w + c1.w, 2.0 * size.w);
    vec2 width = d * size.z / max(vec2(c0.w, c1.w), size.w); // pixels
    vec2 share = vec2(opacity_at(i), opacity_at(i + 1u));
    vec4 c = end ? c1 : c0;
#ifdef WIDE
    if (middle < THIN_BELOW)
        return;
#else
    if (middle >= THIN_BELOW)
        return;
    // A line makes max(|dx|, |dy|) fragments where a ribbon covers
    // width x length pixels: the quotient is the share to keep.
    vec2 run = abs(pixel_of(c1) - pixel_of(c0));
    float longest = max(run.x, run.y);
    float slope = longest > 0.0 ? length(run) / longest : 1.0;
    share *= min(width * slope, 1.0);
#endif
    keep = end ? share.y : share.x;
    if (drawn >= max(share.x, share.y))
        return; // no fragment of it would be kept
#ifdef WIDE
    // Both quads that meet at a point use its own tangent: no gap between.
    vec3 t = tangent_at(end ? i + 1u : i);
    vec4 ct = view_proj * vec4(t, 0.0);
    vec2 way = (ct.xy * c.w - c.xy * ct.w) * size.xy;
    float n = dot(way, way);
    vec2 across = n > 0.0 ? vec2(-way.y, way.x) * inversesqrt(n) : vec2(1, 0);
    c.xy += side * (end ? width.y : width.x) * across / size.xy * c.w;
#endif
    c.xy += jitter.xy * c.w;
    gl_Position = c;
}
