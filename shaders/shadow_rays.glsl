// shadow_rays.glsl - rays that meet real fibres near a point, before the
// voxels take over: what shadow_nodes_rays of shadow.glsl is made of.
// All by texel fetches: some drivers fetch from storage blocks word by word.
layout(binding = 9) uniform usamplerBuffer shadow_starts;
layout(binding = 10) uniform usamplerBuffer shadow_pieces;
layout(binding = 11) uniform samplerBuffer shadow_points; // as in scene.glsl
layout(binding = 12) uniform usamplerBuffer shadow_strands;
#ifdef WITH_OPACITY
layout(binding = 13) uniform samplerBuffer shadow_opacities;
#endif

uint shadow_mix(uint x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// How opaque the fibre is that begins at point i, 0 where the ray misses it.  A
// ribbon that faces the ray: the foot of the perpendicular lies on it, nearer
// than half its diameter.  from, to: the part of the ray that is asked for.
float shadow_meets(int i, vec3 p, vec3 w, float from, float to, uint strand)
{
    vec4 a = texelFetch(shadow_points, i), b = texelFetch(shadow_points, i + 1);
    vec3 d = a.xyz - p, e = b.xyz - a.xyz;
    float dw = dot(d, w), ew = dot(e, w);
    vec3 across = e - ew * w, off = d - dw * w;
    float t = -dot(off, across) / max(dot(across, across), 1e-30);
    off += t * across;
    float far = dw + t * ew, wide = mix(abs(a.w), abs(b.w), t);
    bool own = texelFetch(shadow_strands, i).x == strand;
    float least = own ? max(from, 8.0 * wide) : from;
    bool met = t >= 0.0 && t < 1.0 && far >= least && far < to && far > 0.0 &&
               4.0 * dot(off, off) < wide * wide;
#ifdef WITH_OPACITY
    float o = mix(texelFetch(shadow_opacities, i).x,
                  texelFetch(shadow_opacities, i + 1).x, t);
    return met ? o : 0.0;
#else
    return met ? shadow_texel.w : 0.0;
#endif
}

// What passes the fibres from p along w up to `reach` cells, a fibre of opacity
// o as the factor 1 - s o: a sum over real fibres, so not exp(-s n), which is
// the mean over fibres that may be anywhere.  For s = 1, .3, .05.  Where fibres
// are already many it stops sooner, and reach becomes how far it came: what is
// left of the light there need not be known so well.  g: p in cells.  A fibre
// is listed in every cell that it touches and met in the one where it is.
const vec3 SHADOW_NODES = vec3(1.0, 0.3, 0.05);
const float SHADOW_MANY = 0.35; // .7^3: three fibres
vec3 shadow_near(vec3 p, vec3 g, vec3 w, uint strand, inout float reach)
{
    vec3 size = shadow_cells.xyz, way = sign(w);
    vec3 slow = 1.0 / max(abs(w), vec3(1e-6)); // cells of ray a cell of axis
    vec3 cell = clamp(floor(g), vec3(0.0), size - 1.0);
    vec3 next = (way * (cell - g) + max(way, 0.0)) * slow;
    next = mix(next, vec3(1e9), equal(way, vec3(0.0)));
    float unit = 1.0 / (shadow_box.w * shadow_cells.w), from = -1.0;
    vec3 passes = vec3(1.0);
    float to = min(min(next.x, next.y), min(next.z, reach));
    int at = int(cell.x + size.x * (cell.y + size.y * cell.z));
    uint i = texelFetch(shadow_starts, at).x;
    uint end = texelFetch(shadow_starts, at + 1).x;
    for (;;) {
        if (i < end) {
            int piece = int(texelFetch(shadow_pieces, int(i)).x);
            passes *= 1.0 - SHADOW_NODES * shadow_meets(piece, p, w, from * unit,
                                                   to * unit, strand);
            i++;
        }
        if (i >= end) {
            from = to;
            bvec3 cross = lessThanEqual(next, vec3(to));
            cell += mix(vec3(0.0), way, cross);
            next += mix(vec3(0.0), slow, cross);
            if (to >= reach || passes.y < SHADOW_MANY ||
                any(lessThan(cell, vec3(0.0))) ||
                any(greaterThanEqual(cell, size)))
                break;
            to = min(min(next.x, next.y), min(next.z, reach));
            at = int(cell.x + size.x * (cell.y + size.y * cell.z));
            i = texelFetch(shadow_starts, at).x;
            end = texelFetch(shadow_starts, at + 1).x;
        }
    }
    reach = passes.y < SHADOW_MANY ? from : reach;
    return passes;
}

// Two unit vectors across z, that depend on nothing else.
void shadow_frame(vec3 z, out vec3 x, out vec3 y)
{
    vec3 a = abs(z);
    vec3 least = a.x <= a.y && a.x <= a.z ? vec3(1, 0, 0)
                 : a.y <= a.z             ? vec3(0, 1, 0)
                                          : vec3(0, 0, 1);
    x = normalize(cross(least, z));
    y = cross(z, x);
}
