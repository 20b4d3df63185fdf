// shadow.glsl - what of a light's lobe reaches a point through the hair.
//
// Four numbers stand for it, G(s) = mean over the lobe of exp(-s n), n the
// number of fibres crossed, at s = 1, .6, .25, .05: E[a^N] of a Poisson number
// N of crossings is G(1 - a).  They depend on the hair and the lights' places
// alone.
//   shadow_nodes         the four numbers, packed
//   shadow_nodes_rays    the same with rays against the nearest fibres (with
//                        SHADOW_RAYS defined, for pictures at rest)
//   shadow_unpack        and unpacked
//   shadow_clear, shadow_forward, shadow_crossings   what is read from them
// C side: renderer/crossings.h.
#include "shadow_fall.glsl"

const uint SHADOW_LIGHTS = 200u, SHADOW_WAYS = 1024u;
layout(std140, binding = 5) uniform Crossings {
    vec4 shadow_box;     // corner of the grid; 1 / voxel
    vec4 shadow_size;    // voxels; the start of a lookup, in voxels
    vec4 shadow_texel;   // 1 / atlas size; opacity of all strands
    vec4 shadow_head;    // centre; w = 1 where there is a head
    vec4 shadow_inverse; // 1 / the head's radii; reach of rays, voxels
    uvec4 shadow_light[SHADOW_LIGHTS]; // first way, ways; lambda, a way's width
    vec4 shadow_centre[SHADOW_LIGHTS]; // of the lobe
    vec4 shadow_way[2u * SHADOW_WAYS]; // direction; the tile's corner
};
layout(binding = 8) uniform sampler3D shadow_atlas;

// How much of a bundle of directions about w, of width `wide`, passes the head
// of which o is seen from its centre (in units of its radii): 0 or 1, but where
// the rim lies across the bundle.
float shadow_past_head(vec3 o, vec3 w, float wide)
{
    vec3 d = w * shadow_inverse.xyz;
    float oo = dot(o, o);
    o *= inversesqrt(clamp(oo, 1e-12, 1.0)); // from inside: from its surface
    oo = max(oo, 1.0);
    float c = -dot(o, d) * inversesqrt(dot(d, d)), r = inversesqrt(oo);
    // sines of the angles from the rim to w, and from the plane that touches
    float rim = (sqrt(max((oo - c * c) * (oo - 1.0), 0.0)) - c) * r * r;
    return clamp(0.5 + max(rim, -c * r) / wide, 0.0, 1.0);
}

// exp(-n / 20) along a way from g, in voxels.
float shadow_far(vec3 g, uint way)
{
    vec3 t = clamp(g, vec3(0.5), shadow_size.xyz - 0.5);
    float q = textureLod(shadow_atlas,
                         (t + shadow_way[2u * way + 1u].xyz) * shadow_texel.xyz,
                         0.0).r;
    return SHADOW_ROOT(q);
}

// The four powers of x = exp(-n / 20): exp(-s n), s = 1, .6, .25, .05.
vec4 shadow_powers(float x)
{
    float x2 = x * x, x4 = x2 * x2, x5 = x4 * x, x10 = x5 * x5;
    return vec4(x10 * x10, x10 * x2, x5, x);
}

uvec2 shadow_pack(vec4 g)
{
    return uvec2(packUnorm2x16(g.xy), packUnorm2x16(g.zw));
}

vec4 shadow_unpack(uvec2 bits)
{
    return vec4(unpackUnorm2x16(bits.x), unpackUnorm2x16(bits.y));
}

uvec2 shadow_nodes(uint light, vec3 p, vec3 u, uint segment, uint key)
{
    uvec4 l = shadow_light[light];
    vec3 g = (p - shadow_box.xyz) * shadow_box.w;
    vec3 o = (p - shadow_head.xyz) * shadow_inverse.xyz;
    float wide = uintBitsToFloat(l.w);
    vec4 sum = vec4(0.0);
    for (uint k = l.x; k < l.x + l.y; k++) {
        vec3 w = shadow_way[2u * k].xyz;
        float x = shadow_far(g + shadow_size.w * w, k);
        float open = shadow_head.w > 0.0 ? shadow_past_head(o, w, wide) : 1.0;
        sum += open * shadow_powers(x);
    }
    return shadow_pack(sum / float(max(l.y, 1u)));
}

#ifdef SHADOW_RAYS
#include "shadow_rays.glsl"

// Direction number i of n of a lobe (Xu 2011, eq 2), shifted by two numbers in
// [0, 1).
vec3 shadow_direction(vec3 z, float lambda, uint i, uint n, vec2 shift)
{
    float l2 = lambda * lambda, u = (float(i) + shift.x) / float(n);
    float less = 1.0 - exp(-4.0 / max(l2, 1e-8));
    float lack = min(-0.5 * l2 * log(max(1.0 - (1.0 - u) * less, 1e-30)), 2.0);
    float sine = sqrt(lack * (2.0 - lack));
    float phi = 6.28318531 * fract(0.618033989 * float(i) + shift.y);
    vec3 x, y;
    shadow_frame(z, x, y);
    return normalize(z + (sine * (cos(phi) * x + sin(phi) * y) - lack * z));
}

// `rays` (1 to 16) of them, spread over the lobe by a place's key.  Beyond
// shadow_inverse.w voxels a ray reads the way of the light that is nearest.
uvec2 shadow_nodes_rays(uint light, vec3 p, vec3 u, uint segment, uint key,
                        uint rays)
{
    uvec4 l = shadow_light[light];
    vec3 g = (p - shadow_box.xyz) * shadow_box.w;
    vec3 o = (p - shadow_head.xyz) * shadow_inverse.xyz;
    vec3 z = shadow_centre[light].xyz;
    float lambda = uintBitsToFloat(l.z), reach = shadow_inverse.w;
    // what one ray stands for, as in fill_block of crossings.c
    float wide = max(lambda, 1e-4) * sqrt(3.14159265 / float(rays));
    uint seed = shadow_mix(key ^ shadow_mix(light + 0x9e3779b9u));
    vec2 shift = vec2(seed >> 8u, shadow_mix(seed) >> 8u) / 16777216.0;
    uint strand = strand_of[segment];
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < rays; i++) {
        vec3 w = shadow_direction(z, lambda, i, rays, shift);
        float best = -2.0;
        uint way = l.x;
        for (uint k = l.x; k < l.x + l.y; k++) {
            float c = dot(w, shadow_way[2u * k].xyz);
            way = c > best ? k : way;
            best = max(best, c);
        }
        float open = shadow_head.w > 0.0 ? shadow_past_head(o, w, wide) : 1.0;
        float n = shadow_near(p, g, w, reach, strand);
        float x = shadow_far(g + reach * w, way) * exp(-0.05 * n);
        sum += open * shadow_powers(x);
    }
    return shadow_pack(sum / float(max(rays, 1u)));
}
#endif

// T~: the share that meets no fibre at all.
float shadow_clear(vec4 g)
{
    return g.x;
}

// The Laplace exponent L(s) = -ln G(s) and its slope: q = L/s interpolated
// through the four nodes by Lagrange's cubic.  g > 0.
vec2 shadow_exponent(vec4 g, float s)
{
    const vec4 at = vec4(1.0, 0.6, 0.25, 0.05);
    // products of the nodes' distances from one another
    const vec4 apart = vec4(0.4 * 0.75 * 0.95, -0.4 * 0.35 * 0.55,
                            0.75 * 0.35 * 0.2, -0.95 * 0.55 * 0.2);
    vec4 q = -log(max(g, vec4(7e-6))) / (at * apart), d = s - at;
    vec2 a = vec2(d.x * d.y, d.x + d.y), b = vec2(d.z * d.w, d.z + d.w);
    float value = dot(q.xy, d.yx) * b.x + dot(q.zw, d.wz) * a.x;
    float slope = (q.x + q.y) * b.x + dot(q.xy, d.yx) * b.y +
                  (q.z + q.w) * a.x + dot(q.zw, d.wz) * a.y;
    return vec2(s * value, value + s * slope);
}

// T_f: E[a^N], forward attenuation a.
float shadow_forward(vec4 g, float a)
{
    float s = clamp(1.0 - a, 0.0, 1.0);
    float t = exp(-max(shadow_exponent(g, s).x, 0.0));
    return g.w > 0.0 ? clamp(t, g.x, 1.0) : 0.0;
}

// Mean number of crossings of the light that comes through, a L'(s).
float shadow_crossings(vec4 g, float a)
{
    float s = clamp(1.0 - a, 0.0, 1.0);
    return g.w > 0.0 ? (1.0 - s) * max(shadow_exponent(g, s).y, 0.0) : 0.0;
}
