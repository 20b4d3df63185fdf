#version 450 core
// The raster proper: a thread walks the pixels of one segment.  First the depth
// of each pixel is found (a maximum), then (SETTLE), among the segments that
// were nearest when they were met, whose depth it is; of equal ones the smallest
// number: so the order of threads does not matter.  Long segments are taken
// apart into windows of the picture, each for a thread of its own.
//   lines (without WIDE): for each column of pixels, or row where it is steep,
//   whose middle is in [least, greatest end), the pixel that holds it there;
//   ribbons (WIDE): for each row of pixels those whose middle is in [least,
//   greatest) crossing of the ribbon's outline with the row's middle.
// Two segments that meet share that limit to the bit: no gap, nothing twice.
#include "raster.glsl"
#include "keep.glsl"
#include "raster_work.glsl"
layout(local_size_x = 64) in;
layout(location = 1) uniform uint list; // whose entries are walked

#ifdef WITH_OPACITY
layout(std430, binding = 12) readonly buffer Opacity { float opacity_of[]; };
float opacity_at(uint i) { return opacity_of[i]; }
#else
float opacity_at(uint i) { return hair_colour.w; }
#endif

#ifdef WIDE
const uint KIND = 1u;
#else
const uint KIND = 0u;
#endif
// A window: so many columns or rows, whichever the segment has more of.
const uint WINDOW_BITS = 9u, WHOLE = 511u;
const int WINDOW = 32, LONG = 48;

Lie lie;
vec2 kept;   // share of the samples, in which its ends are kept
float drawn; // this strand's number in this sample: kept if below
uint segment = 0u, window = WHOLE;
bool won = false;

// A pixel that the segment covers, at some depth.
void cover(uint at, float depth)
{
    uint mine = floatBitsToUint(depth);
#ifdef SETTLE
    if (mine == depth_seen[at] && atomicMin(seen_id[at], segment) == RASTER_NONE)
        list_entry(PIXELS, at, 1u);
#else
    if (mine >= depth_seen[at] && mine >= atomicMax(depth_seen[at], mine))
        won = true;
#endif
}

// The n-th thread's part of the list.
bool fetch(uint n)
{
    uint count = work[list].w;
    if (list < WINDOWS) {
        if (n / RASTER_GROUP >= count)
            return false;
        segment = entry[entry_of(list, n / RASTER_GROUP)] * RASTER_GROUP +
                  n % RASTER_GROUP;
        return segment + 1u < sample_index.y;
    }
    if (n >= (list < NEAREST ? min(count, raster_room.y) : count))
        return false;
    uint key = entry[entry_of(list, n)];
    segment = key >> WINDOW_BITS;
    window = key & WHOLE;
    return true;
}

// Cuts [first, end) of columns or rows down to the window, or hands a long one
// on, window by window; where those have no room it only takes longer.
void cut(inout int first, inout int end)
{
    if (window != WHOLE) {
        first = max(first, int(window) * WINDOW);
        end = min(end, int(window) * WINDOW + WINDOW);
    } else if (list < WINDOWS && end - first > LONG) {
        for (int w = first / WINDOW; w * WINDOW < end; w++) {
            if (!list_entry(WINDOWS + KIND, segment << WINDOW_BITS | uint(w),
                            1u))
                break;
            first = w * WINDOW + WINDOW;
        }
    }
}

// The first pixel whose middle is not below x, within 0..most.
int first_from(float x, int most)
{
    return int(ceil(clamp(x, 0.0, float(most)) - 0.5));
}

// Share and depth are linear in pixels.
#ifndef WIDE
void walk()
{
    vec2 d = lie.b - lie.a;
    bool steep = abs(d.y) > abs(d.x);
    ivec2 extent = ivec2(size.xy), high = steep ? extent.yx : extent;
    uvec2 stride = steep ? uvec2(extent.x, 1) : uvec2(1, extent.x);
    vec2 a = steep ? lie.a.yx : lie.a, b = steep ? lie.b.yx : lie.b;
    float over = a.x != b.x ? 1.0 / (b.x - a.x) : 0.0;
    float tilt = (b.y - a.y) * over;
    // A line makes max(|dx|, |dy|) fragments where a ribbon covers width x
    // length pixels: the quotient is the share to keep.
    vec2 width = mix(lie.diameter.xx, lie.diameter.yy, lie.at) * lie.depth;
    kept *= min(width * sqrt(1.0 + tilt * tilt) * (size.z / size.w), 1.0);
    int first = first_from(min(a.x, b.x), high.x);
    int end = first_from(max(a.x, b.x), high.x);
    if (drawn >= max(kept.x, kept.y))
        end = first; // no pixel of it would be kept
    cut(first, end);
    float kept_step = (kept.y - kept.x) * over;
    precise float depth_step = (lie.depth.y - lie.depth.x) * over;
    for (int u = first; u < end; u++) {
        precise float t = float(u) + 0.5 - a.x;
        precise float depth = lie.depth.x + t * depth_step;
        int v = int(floor(clamp(a.y + t * tilt, -1.0, float(high.y))));
        if (v >= 0 && v < high.y && drawn < kept.x + t * kept_step)
            cover(uint(u) * stride.x + uint(v) * stride.y, depth);
    }
}
#else
// Half a ribbon's width at point i, pixels.  Both ribbons that meet at a point
// use its own tangent: no gap between.
vec2 half_across(uint i, vec3 c, float width)
{
    bool inner = i > 0u;
    vec4 before = texelFetch(raster_points, int(inner ? i - 1u : 0u));
    vec4 here = texelFetch(raster_points, int(i));
    bool last = here.w < 0.0;
    vec4 after = texelFetch(raster_points, int(last ? i : i + 1u));
    precise vec3 t = after.xyz - (inner && before.w > 0.0 ? before : here).xyz;
    precise vec3 ct = view_proj[0].xyw * t.x + view_proj[1].xyw * t.y +
                      view_proj[2].xyw * t.z;
    precise vec2 go = (ct.xy * c.z - c.xy * ct.z) * size.xy;
    precise float n = go.x * go.x + go.y * go.y;
    precise vec2 across = n > 0.0 ? vec2(-go.y, go.x) * inversesqrt(n) : vec2(1, 0);
    precise vec2 h = 0.5 * width * across;
    return h;
}

// An edge of the outline: from its lower end (x, y), columns a row, to row.
vec4 edge_of(vec2 p, vec2 q)
{
    vec2 low = p.y <= q.y ? p : q, high = p.y <= q.y ? q : p;
    float rise = high.y - low.y;
    precise float lean = (high.x - low.x) / rise;
    return vec4(low, rise > 0.0 ? lean : 0.0, high.y);
}

void meet(vec4 edge, float y, inout vec2 limits)
{
    precise float x = edge.x + (y - edge.y) * edge.z;
    if (y >= edge.y && y < edge.w)
        limits = vec2(min(limits.x, x), max(limits.y, x));
}

void walk()
{
    ivec2 extent = ivec2(size.xy);
    float scale = size.z / size.w;
    vec2 diameter = mix(lie.diameter.xx, lie.diameter.yy, lie.at);
    diameter = vec2(lie.cut.x ? diameter.x : lie.diameter.x,
                    lie.cut.y ? diameter.y : lie.diameter.y);
    precise vec2 width = diameter * lie.depth * scale;
    vec2 d = lie.b - lie.a;
    vec2 straight = vec2(-d.y, d.x) * inversesqrt(max(dot(d, d), 1e-30));
    vec2 ha = lie.cut.x ? 0.5 * width.x * straight
                        : half_across(segment, lie.p0, width.x);
    vec2 hb = lie.cut.y ? 0.5 * width.y * straight
                        : half_across(segment + 1u, lie.p1, width.y);
    precise vec2 a0 = lie.a - ha, a1 = lie.a + ha;
    precise vec2 b0 = lie.b - hb, b1 = lie.b + hb;
    vec4 start = edge_of(a0, a1), stop = edge_of(b0, b1);
    vec4 left = edge_of(a0, b0), right_side = edge_of(a1, b1);
    vec2 low = min(min(a0, a1), min(b0, b1));
    vec2 high = max(max(a0, a1), max(b0, b1));
    int x0 = first_from(low.x, extent.x), x1 = first_from(high.x, extent.x);
    int y0 = first_from(low.y, extent.y), y1 = first_from(high.y, extent.y);
    if (drawn >= max(kept.x, kept.y))
        y1 = y0; // no pixel of it would be kept
    bool flat_lying = x1 - x0 > y1 - y0;
    int first = flat_lying ? x0 : y0, end = flat_lying ? x1 : y1;
    cut(first, end);
    if (flat_lying) {
        // rows that the ribbon has in these columns: its middle's, and as far
        // beyond as the outline's corners are
        float tilt = d.x != 0.0 ? d.y / d.x : 0.0;
        vec4 off = abs(vec4(ha.y - ha.x * tilt, hb.y - hb.x * tilt, 0, 0));
        float ya = lie.a.y + (float(first) - lie.a.x) * tilt;
        float yb = lie.a.y + (float(end) - lie.a.x) * tilt;
        float m = max(off.x, off.y) + 1.0;
        x0 = first;
        x1 = end;
        if (d.x != 0.0) {
            y0 = max(y0, first_from(min(ya, yb) - m, extent.y));
            y1 = min(y1, first_from(max(ya, yb) + m, extent.y));
        }
    } else {
        y0 = first;
        y1 = end;
    }
    vec2 way = way_of(lie);
    uint row = 0u;
    precise float at_row = 0.0; // how far along is the row's first pixel?
    int y = y0 - 1, x = 0, until = 0;
    if (x1 <= x0)
        y = y1;
    while (y < y1) {
        if (x >= until) {
            y++;
            float middle = float(y) + 0.5;
            vec2 limits = vec2(1e9, -1e9);
            meet(start, middle, limits);
            meet(stop, middle, limits);
            meet(left, middle, limits);
            meet(right_side, middle, limits);
            x = max(x0, first_from(limits.x, extent.x));
            until = y < y1 ? min(x1, first_from(limits.y, extent.x)) : 0;
            row = uint(y) * uint(extent.x);
            at_row = (0.5 - lie.a.x) * way.x + (middle - lie.a.y) * way.y;
        }
        precise float s = clamp(at_row + float(x) * way.x, 0.0, 1.0);
        precise float depth = depth_of(lie, s);
        if (x < until && drawn < kept.x + s * (kept.y - kept.x))
            cover(row + uint(x), depth);
        x++;
    }
}
#endif

void main()
{
    uint n = gl_GlobalInvocationID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x *
                                           64u;
    if (!fetch(n))
        return;
    lie = lie_of(segment);
    float middle = (lie.diameter.x + lie.diameter.y) * size.z /
                   max(lie.p0.z + lie.p1.z, 2.0 * size.w);
    if (!lie.seen || (middle < THIN_BELOW) != (KIND == 0u))
        return;
    drawn = keep_draw(strand_of[segment], sample_index.x);
    kept = mix(vec2(opacity_at(segment)), vec2(opacity_at(segment + 1u)),
                lie.at);
    walk();
#ifndef SETTLE
    if (won)
        list_entry(NEAREST + KIND, segment << WINDOW_BITS | window, 1u);
#endif
}
