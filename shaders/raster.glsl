// raster.glsl - how a segment lies in the picture, for who looks for the pixels
// that it covers (raster_walk.comp) and who asks where on it a pixel is
// (cells.comp).  Both must find the same, to the bit: hence `precise`.
#include "scene.glsl"
layout(binding = 18) uniform samplerBuffer raster_points; // as points[]

// Below this width in pixels a segment is a line, which covers one pixel across
// its minor axis: a strand's share stays under 1 for every slope.
const float THIN_BELOW = 0.7;

const uint RASTER_NONE = 0xffffffffu; // what no segment is

struct Lie {
    bool seen;     // some of it is in front of the near plane
    bvec2 cut;     // an end is not its own but where the near plane cuts
    vec3 p0, p1;   // clip x, y, w of the ends as they are, unjittered
    vec2 diameter; // of the ends as they are, world
    vec2 a, b;     // pixels, jittered, of what is seen
    vec2 depth;    // near / w there
    vec2 at;       // 0..1 on the segment, there
};

Lie lie_of(uint segment)
{
    Lie l;
    vec4 q0 = texelFetch(raster_points, int(segment));
    vec4 q1 = texelFetch(raster_points, int(segment) + 1);
    vec3 c0 = clip_of(q0.xyz).xyw, c1 = clip_of(q1.xyz).xyw;
    l.p0 = c0;
    l.p1 = c1;
    l.diameter = vec2(q0.w, abs(q1.w));
    // A strand's last point begins no segment.
    l.seen = q0.w >= 0.0 && max(c0.z, c1.z) > size.w;
    l.cut = lessThan(vec2(c0.z, c1.z), vec2(size.w));
    precise float t = (size.w - c0.z) / (c1.z - c0.z);
    precise vec3 c = c0 + t * (c1 - c0);
    c.z = size.w;
    l.at = vec2(l.cut.x ? t : 0.0, l.cut.y ? t : 1.0);
    c0 = l.cut.x ? c : c0;
    c1 = l.cut.y ? c : c1;
    precise vec2 over = 1.0 / vec2(c0.z, c1.z), half_size = 0.5 * size.xy;
    precise vec2 depth = size.w * over;
    precise vec2 pa = (c0.xy * over.x + jitter.xy) * half_size + half_size;
    precise vec2 pb = (c1.xy * over.y + jitter.xy) * half_size + half_size;
    l.depth = depth;
    l.a = pa;
    l.b = pb;
    return l;
}

// Of the pixel's middle, dropped on the segment: 0 at a, 1 at b.  q: what
// way_of says, so that it is formed once for a segment.
vec2 way_of(Lie l)
{
    precise vec2 d = l.b - l.a;
    precise float n = d.x * d.x + d.y * d.y;
    return n > 0.0 ? d / n : vec2(0.0);
}

float foot_of(Lie l, vec2 way, vec2 pixel)
{
    precise vec2 d = pixel - l.a;
    precise float s = d.x * way.x + d.y * way.y;
    return clamp(s, 0.0, 1.0);
}

float depth_of(Lie l, float s)
{
    precise float depth = l.depth.x + s * (l.depth.y - l.depth.x);
    return depth;
}

// 0..1 on the segment: perspective makes of s what is linear in 1 / w.
float along_of(Lie l, float s, float depth)
{
    vec2 v = l.at * l.depth;
    return clamp((v.x + s * (v.y - v.x)) / depth, 0.0, 1.0);
}
