// shadow.glsl - what of a light's lobe reaches a point through the hair.
//
// Four numbers stand for it, the nodes: G(s) = mean over the lobe of
// exp(-s n), n the number of fibres crossed, at s = 1, .3, .05 and 0, where
// what the head hides counts nothing.  E[a^N] of a Poisson number N of
// crossings is G(1 - a), so G(0) is what an unshaded head of hair would get.
// They depend on the hair and the lights' places alone.
//   shadow_nodes         the nodes, packed
//   shadow_nodes_rays    the same with rays against the nearest fibres (with
//                        SHADOW_RAYS defined, for pictures at rest).  A light
//                        an invocation: all lights in one would be a loop of
//                        more turns than some drivers finish (65535)
//   shadow_unpack        and unpacked
//   shadow_law           from nodes to G at any s, and from it
//   shadow_clear, shadow_forward, shadow_crossings
// With SHADOW_MAP defined the nodes come from optical depth maps instead.
// C side: renderer/crossings.h.
#include "guard.glsl"
#include "shadow_fall.glsl"

const uint SHADOW_LIGHTS = 200u, SHADOW_WAYS = 1024u;
layout(std140, binding = 5) uniform Crossings {
    vec4 shadow_box;     // corner of the grid; 1 / voxel
    vec4 shadow_size;    // voxels
    vec4 shadow_texel;   // 1 / the atlas's sides; opacity of all strands
    vec4 shadow_head;    // centre; w = 1 where there is a head
    vec4 shadow_inverse; // 1 / the head's radii; reach of rays, cells
    vec4 shadow_cells;   // of the lists of fibres; cells a voxel
    uvec4 shadow_all;    // banks; texels to the next along y, z, bank
    uvec4 shadow_light[SHADOW_LIGHTS]; // first way, ways; lambda, a way's width
    vec4 shadow_centre[SHADOW_LIGHTS]; // of the lobe
    vec4 shadow_way[SHADOW_WAYS];      // direction; its slot
    // Sixteen slots a bank: direction as the head sees it, 1 / the way's width
    vec4 shadow_slot[SHADOW_WAYS];
    uvec4 shadow_run[SHADOW_WAYS / 4u]; // what to do after a slot, see below
};
// After a slot: nothing, or a run of ways of one light ends here (or of none:
// slots that no way has), which are summed into row - 1; where it is not the
// light's first, its bits are added.  Where there are several, each is rounded
// down (see shadow_run_bits).
const uint RUN_ROW = 255u, RUN_END = 256u, RUN_AGAIN = 512u, RUN_SHARED = 1024u;
const uint RUN_WAYS = 16u; // shift: of the light
// A bank after the other, a texel a voxel, x fastest, a byte a slot: what a
// filter would do for four of them a lookup is done here for all sixteen.
layout(binding = 8) uniform usamplerBuffer shadow_field;

// A place as the grid sees it (voxels) and as the head does (from its centre,
// in units of its radii, from inside on its surface).
struct ShadowPlace {
    vec3 g, o;
    float oo, r; // o.o, at least 1; 1 / its root
};

ShadowPlace shadow_place(vec3 p)
{
    ShadowPlace s;
    s.g = (p - shadow_box.xyz) * shadow_box.w;
    s.o = (p - shadow_head.xyz) * shadow_inverse.xyz;
    s.oo = dot(s.o, s.o);
    s.o *= inversesqrt(clamp(s.oo, 1e-12, 1.0));
    s.oo = max(s.oo, 1.0);
    s.r = inversesqrt(s.oo);
    return s;
}

// How much of a bundle of directions about d (unit, as the head sees it), of
// width 1 / narrow, passes the head: 0 or 1, but where the rim lies across the
// bundle.
float shadow_past_head(ShadowPlace s, vec3 d, float narrow)
{
    float c = -dot(s.o, d);
    // sines of the angles from the rim to d, and from the plane that touches
    float rim = sqrt(max((s.oo - c * c) * (s.oo - 1.0), 0.0)) - c;
    float open = clamp(0.5 + max(rim * s.r * s.r, -c * s.r) * narrow, 0.0, 1.0);
    return shadow_head.w > 0.0 ? open : 1.0;
}

// The eight voxels about g, in voxels: the first one's texel in bank 0; what each
// counts, over 255: along x, then y, at the lower z and the higher.
struct ShadowCorner {
    int at;
    vec4 low, high;
};

ShadowCorner shadow_corner(vec3 g)
{
    vec3 t = clamp(g, vec3(0.5), shadow_size.xyz - 0.5) - 0.5;
    vec3 base = min(floor(t), shadow_size.xyz - 2.0), part = t - base;
    uvec3 at = uvec3(base);
    vec4 x = vec4(1.0 - part.x, part.x, 1.0 - part.x, part.x) * (1.0 / 255.0);
    vec4 xy = x * vec4(vec2(1.0 - part.y), vec2(part.y));
    ShadowCorner c;
    c.at = int(at.x + at.y * shadow_all.y + at.z * shadow_all.z);
    c.low = xy * (1.0 - part.z);
    c.high = xy * part.z;
    return c;
}

// A bank's texels about a place.
struct ShadowBank {
    uvec4 low[4], high[4];
};

ShadowBank shadow_bank(ShadowCorner c, uint bank)
{
    int y = int(shadow_all.y), z = int(shadow_all.z);
    int i = c.at + int(bank * shadow_all.w), j = i + z;
    ShadowBank b;
    b.low[0] = texelFetch(shadow_field, i);
    b.low[1] = texelFetch(shadow_field, i + 1);
    b.low[2] = texelFetch(shadow_field, i + y);
    b.low[3] = texelFetch(shadow_field, i + y + 1);
    b.high[0] = texelFetch(shadow_field, j);
    b.high[1] = texelFetch(shadow_field, j + 1);
    b.high[2] = texelFetch(shadow_field, j + y);
    b.high[3] = texelFetch(shadow_field, j + y + 1);
    return b;
}

// exp(-SHADOW_FALL n) along a slot's way, from the voxel's side on
// (crossings_sweep.comp).  low, high: its word of the eight texels.
float shadow_mixed(ShadowCorner c, uvec4 low, uvec4 high, uint slot)
{
    uint shift = 8u * (slot & 3u);
    return dot(vec4(low >> shift & 255u), c.low) +
           dot(vec4(high >> shift & 255u), c.high);
}

float shadow_read(ShadowCorner c, uint slot)
{
    ShadowBank b = shadow_bank(c, slot >> 4u);
    uint k = slot >> 2u & 3u;
    return shadow_mixed(
        c, uvec4(b.low[0][k], b.low[1][k], b.low[2][k], b.low[3][k]),
        uvec4(b.high[0][k], b.high[1][k], b.high[2][k], b.high[3][k]), slot);
}

// The nodes of one way: powers of q = exp(-SHADOW_FALL n).
vec4 shadow_powers(float q)
{
    float root = sqrt(q), q2 = q * q;
    return vec4(q2 * q2 * q, q * root, sqrt(root), 1.0);
}

uvec2 shadow_pack_by(vec4 g, float up)
{
    uvec4 bits = uvec4(clamp(g, 0.0, 1.0) * 65535.0 + up);
    return bits.xz | bits.yw << 16u;
}

uvec2 shadow_pack(vec4 g)
{
    return shadow_pack_by(g, 0.5);
}

// The bits of a run.  A light's ways may be in six runs, whose bits are added
// without a carry into the neighbour: six times up to an eighth is less than 1.
uvec2 shadow_run_bits(vec4 sum, uint run)
{
    float share = 1.0 / float(run >> RUN_WAYS);
    return shadow_pack_by(sum * share,
                          (run & RUN_SHARED) != 0u ? 0.125 : 0.5);
}

vec4 shadow_unpack(uvec2 bits)
{
    return vec4(unpackUnorm2x16(bits.x), unpackUnorm2x16(bits.y));
}

// The nodes of the way in a slot of which q is known.
vec4 shadow_slot_nodes(ShadowPlace s, uint slot, float q)
{
    vec4 h = shadow_slot[slot];
    return shadow_past_head(s, h.xyz, h.w) * shadow_powers(q);
}

vec4 shadow_along(ShadowPlace s, uint slot)
{
    return shadow_slot_nodes(s, slot, shadow_read(shadow_corner(s.g), slot));
}

// The very bits that shadow.comp makes of all lights at once.
uvec2 shadow_smooth(ShadowPlace s, uint light)
{
    uvec4 l = shadow_light[light];
    vec4 sum = vec4(0.0);
    uvec2 bits = uvec2(0u);
    for (uint k = l.x; k < l.x + l.y; k++) {
        uint slot = uint(shadow_way[k].w);
        uint run = shadow_run[slot >> 2u][slot & 3u];
        sum += shadow_along(s, slot);
        bits += (run & RUN_END) != 0u ? shadow_run_bits(sum, run) : uvec2(0u);
        sum = (run & RUN_END) != 0u ? vec4(0.0) : sum;
    }
    return bits;
}

#ifdef SHADOW_MAP
#include "shadow_map.glsl"
#endif

uvec2 shadow_nodes(uint light, vec3 p, vec3 u, uint segment, uint key)
{
#ifdef SHADOW_MAP
    return shadow_pack(shadow_mapped(light, p, shadow_place(p)));
#else
    return shadow_smooth(shadow_place(p), light);
#endif
}

#ifdef SHADOW_RAYS
#include "shadow_rays.glsl"

// Direction number i of n of a lobe (Xu 2011, eq 2), shifted by two numbers in
// [0, 1).
vec3 shadow_direction(vec3 z, float lambda, uint i, uint n, vec2 shift)
{
    float l2 = lambda * lambda, u = (float(i) + shift.x) / float(n);
    float less = 1.0 - exp(-4.0 / max(l2, 1e-8));
    float lack = -0.5 * l2 * log(max(1.0 - (1.0 - u) * less, 1e-30));
    lack = clamp(lack, 0.0, 2.0); // a log near 1 may be rounded to above 0
    float sine = sqrt(lack * (2.0 - lack));
    float phi = 6.28318531 * fract(0.618033989 * float(i) + shift.y);
    vec3 x, y;
    shadow_frame(z, x, y);
    return normalize(z + (sine * (cos(phi) * x + sin(phi) * y) - lack * z));
}

// `rays` (1 to 16) of them, spread over the lobe by a place's key.  Where a ray
// ends it reads on along the light's way that is nearest.  What is averaged is
// by how much that differs from what this way alone says (a control variate):
// few rays then find what the voxels miss without being noisier than needed.
// What n rays add counts n / (n + c): as much as makes the expected square of
// the error least, c being the variance of one ray over the square of the smooth
// field's error.  A wide lobe's rays differ more among themselves and its field
// errs less: c = 10 lambda, measured (docs/SHADOWS.md); 0 for a sun, whose one
// ray is the answer.
const float SHADOW_DOUBT = 10.0;
uvec2 shadow_nodes_rays(uint light, vec3 p, vec3 u, uint segment, uint key,
                        uint rays)
{
    uvec4 l = shadow_light[light];
    ShadowPlace s = shadow_place(p);
    vec3 z = shadow_centre[light].xyz;
    float lambda = uintBitsToFloat(l.z);
    // The farther a ray decides, the nearer the mean of many to the truth, and
    // the noisier that of few; a narrow lobe's differ less.
    float wider = rays < 8u ? 1.0 : 1.5;
    float longer = 1.0 + 0.5 * log2(float(max(rays, 1u)));
    float reach = shadow_inverse.w * (lambda <= 0.1 ? longer : wider);
    // Half of what one ray stands for (see fill_block of crossings.c): where it
    // goes is drawn already, and the head's rim shall not be blurred twice.
    float narrow = inversesqrt(0.785398163 / float(rays)) / max(lambda, 1e-4);
    uint seed = shadow_mix(key ^ shadow_mix(light + 0x9e3779b9u));
    vec2 shift = vec2(seed >> 8u, shadow_mix(seed) >> 8u) / 16777216.0;
    uint strand = texelFetch(shadow_strands, int(segment)).x;
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < rays; i++) {
        vec3 w = shadow_direction(z, lambda, i, rays, shift);
        float best = -2.0;
        uint way = l.x;
        for (uint k = l.x; k < l.x + l.y; k++) {
            float c = dot(w, shadow_way[k].xyz);
            way = c > best ? k : way;
            best = max(best, c);
        }
        float open =
            shadow_past_head(s, normalize(w * shadow_inverse.xyz), narrow);
        float end = reach; // how far fibres were met, in cells
        vec3 near = shadow_near(p, s.g * shadow_cells.w, w, strand, end);
        uint slot = uint(shadow_way[way].w);
        vec3 d = shadow_way[way].xyz, a = abs(d);
        // what is read begins half a voxel's side further along the way
        vec3 g = s.g + (end / shadow_cells.w) * w -
                 d * (0.5 / max(a.x, max(a.y, a.z)));
        float q = shadow_read(shadow_corner(g), slot);
        sum += open * vec4(near, 1.0) * shadow_powers(q);
        sum -= shadow_along(s, slot);
    }
    vec4 mean = shadow_unpack(shadow_smooth(s, light)) +
                sum / (float(max(rays, 1u)) + SHADOW_DOUBT * lambda);
    mean.w = clamp(mean.w, 0.0, 1.0);
    mean.z = clamp(mean.z, 0.0, mean.w);
    mean.y = clamp(mean.y, 0.0, mean.z);
    mean.x = clamp(mean.x, 0.0, mean.y);
    return shadow_pack(mean);
}
#endif

// G between its nodes: G(s) = open exp(-s / R(s)), R the parabola through what
// the nodes make of it.  Exact where all ways cross equally many fibres.
struct ShadowLaw {
    vec3 r;      // R = r.x + s (r.y + s r.z)
    vec2 bounds; // of R
    float open;  // G(0)
    float clear; // G(1)
};

// fall: -ln of G / G(0) at the nodes.
ShadowLaw shadow_law_of(vec3 fall, float open, float clear)
{
    vec3 R = vec3(1.0, 0.3, 0.05) / max(fall, vec3(1e-6));
    ShadowLaw l;
    l.r = R.x * (1.0 / 0.665) * vec3(0.015, -0.35, 1.0) -
          R.y * (1.0 / 0.175) * vec3(0.05, -1.05, 1.0) +
          R.z * (1.0 / 0.2375) * vec3(0.3, -1.3, 1.0);
    l.bounds = vec2(0.25 * R.z, max(R.x, R.z));
    l.open = open;
    l.clear = clear;
    return l;
}

vec3 shadow_fall_of(vec4 g)
{
    const float least = 7e-6; // half of what a node can hold
    vec3 fall = log(max(g.w, least)) - log(max(g.xyz, vec3(least)));
    GUARD_LIVE(g.w > 0.0);
    GUARD(GUARD_SHADOW_LEAST, lessThan(g, vec4(least)));
    GUARD(GUARD_SHADOW_FALL, lessThan(fall, vec3(-1e-3)));
    return fall;
}

ShadowLaw shadow_law(vec4 g)
{
    return shadow_law_of(shadow_fall_of(g), g.w, g.x);
}

// T~: the share that meets no fibre at all.
float shadow_clear(vec4 g)
{
    return g.x;
}

// About as many fibres as are crossed where the head hides nothing; at most
// 220.
float shadow_mean(vec4 g)
{
    return 20.0 * log(max(g.w, 2e-5) / max(g.z, 2e-5));
}

// T_f: E[a^N] for three forward attenuations, 0 to 1.  Between T~ and G(0).
vec3 shadow_forward(ShadowLaw l, vec3 a)
{
    vec3 s = clamp(1.0 - a, 0.0, 1.0);
    vec3 R = clamp(l.r.x + s * (l.r.y + s * l.r.z), l.bounds.x, l.bounds.y);
    GUARD_LIVE(l.open > 0.0);
    // By what it makes of T_f: a node holds 1.5e-5.
    GUARD(GUARD_SHADOW_LAW,
          greaterThan(l.open * abs(exp(-s / R) -
                                   exp(-s / max(l.r.x + s * (l.r.y + s * l.r.z),
                                                1e-6))),
                      vec3(1e-3)));
    GUARD(GUARD_SHADOW_FORWARD,
          lessThan(l.open * exp(-s / R), vec3(l.clear - 1e-3)));
    return clamp(l.open * exp(-s / R), l.clear, l.open);
}

// Mean number of crossings of the light that comes through: a d/ds of
// -ln G.  0 where none comes.
vec3 shadow_crossings(ShadowLaw l, vec3 a)
{
    vec3 s = clamp(1.0 - a, 0.0, 1.0);
    vec3 R = clamp(l.r.x + s * (l.r.y + s * l.r.z), l.bounds.x, l.bounds.y);
    vec3 rest = R - s * (l.r.y + 2.0 * s * l.r.z);
    GUARD(GUARD_SHADOW_CROSSINGS, lessThan(rest, -0.01 * R));
    return l.open > 0.0 ? (1.0 - s) * max(rest, 0.0) / (R * R) : vec3(0.0);
}
