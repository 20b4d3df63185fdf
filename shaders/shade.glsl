// shade.glsl - radiance of a place of the hair from a range of lights: lights
// in the inner loop.  The fibre's diameter cancels (a strand drawn as a ribbon
// of its own width has radiance = curve intensity / diameter).
//
// For each light and colour channel (docs/METHODS.md):
//   T~ (M + d_b M^L_direct) + d_f (T_f - T~) Omega (M^G + d_b M^L)
// direct light and its local glow, and light that came forward through other
// fibres and its glow.  Variants leave out what a scene does not need.
#include "scene.glsl"
#include "cells.glsl"
#include "lights.glsl"
#include "xu.glsl"
#if defined(XU_BEST) || defined(FAST)
#include "best.glsl"
#endif
#include "place.glsl"
#ifdef WITH_SHADOW
#include "shadow.glsl"
#ifdef SHADOW_STORED
#include "nodes.glsl"
#endif
#endif
#ifdef WITH_MULTIPLE
#include "dual.glsl"
#endif
#ifdef XU_BEST
#define SINGLE_MODES(f, l, theta_o, phi_o, r, tt, trt)                         \
    best_modes(f, best, l, theta_o, phi_o, r, tt, trt)
#else
#define SINGLE_MODES xu_modes
#endif

#ifdef WITH_COLOUR
layout(std430, binding = 2) readonly buffer Colour { vec4 colour_of[]; };
vec3 colour_at(uint i, float t)
{
    return mix(colour_of[i].rgb, colour_of[i + 1u].rgb, t);
}
#else
vec3 colour_at(uint i, float t) { return hair_colour.rgb; }
#endif

#ifdef XU_ECCENTRIC
layout(std430, binding = 3) readonly buffer Axis { uint axis_of[]; };
vec3 unpack_axis(uint bits)
{
    vec2 e = unpackSnorm2x16(bits);
    vec3 v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    if (v.z < 0.0)
        v.xy = (1.0 - abs(v.yx)) * mix(vec2(-1.0), vec2(1.0),
                                       greaterThanEqual(v.xy, vec2(0.0)));
    return v;
}
#endif

// Across the fibre: the major axis of an eccentric fibre, else towards the
// viewer, which makes phi_o zero.
vec3 across_of(Place c, vec3 to_eye)
{
    vec3 side = to_eye;
#ifdef XU_ECCENTRIC
    side = mix(unpack_axis(axis_of[c.segment]),
               unpack_axis(axis_of[c.segment + 1u]), c.along);
#endif
    vec3 v = side - dot(side, c.u) * c.u;
    float n = dot(v, v);
    if (n < 1e-10) { // looking along the fibre: any direction will do
        side = abs(c.u.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
        v = side - dot(side, c.u) * c.u;
        n = dot(v, v);
    }
    return v * inversesqrt(n);
}

float azimuth(vec3 d, vec3 v, vec3 w)
{
    float x = dot(d, v), y = dot(d, w);
    return abs(x) + abs(y) > 0.0 ? atan(y, x) : 0.0;
}

Fibre fibre_here()
{
    return Fibre(fibre_eta, fibre_sigma_a, fibre_a,
                 vec3(fibre_alpha_r, fibre_alpha_tt, fibre_alpha_trt),
                 vec3(fibre_beta_r, fibre_beta_tt, fibre_beta_trt), fibre_w_c,
                 fibre_delta_eta);
}

#ifdef WITH_SHADOW
vec4 nodes_of(uint light, Place c, uint at)
{
#ifdef SHADOW_STORED
    return shadow_unpack(texelFetch(nodes, int(light * nodes_stride + at)).xy);
#else
    return shadow_unpack(shadow_nodes(light, c.p, c.u, c.segment, c.key));
#endif
}
#else
vec4 nodes_of(uint light, Place c, uint at) { return vec4(1.0); }
float shadow_clear(vec4 g) { return g.x; }
float shadow_mean(vec4 g) { return 0.0; }
#endif

#ifdef VIEW_FIELD
// What shadows are made of, weighted by the lights: the share that arrives
// unblocked, or the fibres crossed (mean, of ten).
vec3 field(Place c, uint at)
{
    vec4 sum = vec4(0.0);
    for (uint j = 0u; j < light_count; j++) {
        vec4 g = nodes_of(j, c, at);
        vec3 power = lights[j].radiance.rgb * lights[j].radiance.w;
        float weight = dot(power, vec3(0.2126, 0.7152, 0.0722));
        float t = shadow_clear(g);
        float n = g.w > 0.0 ? shadow_mean(g) : 100.0; // the head hides it
        sum += weight * vec4(t, min(n, 100.0) / 10.0, 0.0, 1.0);
    }
    vec2 mean = sum.xy / max(sum.w, 1e-30);
    return vec3(VIEW_FIELD == 0 ? mean.x : mean.y);
}
#endif

#ifdef FAST
#include "shade_fast.glsl"
#ifdef LIT
#include "shade_lit.glsl"
#endif
#else
#ifdef WITH_MULTIPLE
// Light that was scattered on its way or is scattered back by the hair around.
vec3 scattered(Fibre fibre, DualView view, Srbf light, float phi_o, vec4 g,
               float omega)
{
    DualAt at = dual_forward(light.theta);
    ShadowLaw law = shadow_law(g);
    vec3 through = shadow_forward(law, at.a_f);
    vec3 crossed = shadow_crossings(law, at.a_f);
    // every crossing widens the light by (2 beta)^2, a variance; a Xu width
    // squared is twice that (Zinke 2008, eq 8)
    vec3 sigma_f =
        sqrt(light.lambda * light.lambda + 8.0 * at.betabar2_f * crossed);
    vec3 global, local, near;
    dual_modes(fibre, view, light, phi_o, sigma_f, vec3(1.0), global, local,
               near);
    float clear = shadow_clear(g), glow = share.y * fibre_d_b;
    vec3 forward = fibre_d_f * omega * max(through - clear, 0.0);
    return clear * glow * near + forward * (share.x * global + glow * local);
}
#endif

vec3 shade(Place c, uint at, uint first, uint end)
{
    vec3 to_eye = normalize(eye.xyz - c.p), v = across_of(c, to_eye);
    vec3 w = cross(c.u, v);
    float theta_o = special_asin(clamp(dot(to_eye, c.u), -1.0, 1.0));
    float phi_o = azimuth(to_eye, v, w);
    Fibre fibre = fibre_here();
#ifdef WITH_MULTIPLE
    DualView view = dual_view(theta_o);
#endif
#if defined(XU_BEST) && defined(WITH_SINGLE)
    BestFibre best = best_fibre();
#endif
    vec3 sum = vec3(0.0);
    for (uint j = first; j < end; j++) {
        vec4 place = lights[j].place;
        Srbf light =
            Srbf(special_asin(clamp(dot(place.xyz, c.u), -1.0, 1.0)),
                 azimuth(place.xyz, v, w), place.w);
        vec4 g = nodes_of(j, c, at);
        vec3 r, tt, trt, seen = vec3(0.0);
#ifdef WITH_SINGLE
        SINGLE_MODES(fibre, light, theta_o, phi_o, r, tt, trt);
        seen = shadow_clear(g) * (mask.x * r + mask.y * tt + mask.z * trt);
#endif
#ifdef WITH_MULTIPLE
        seen += scattered(fibre, view, light, phi_o, g, lights[j].radiance.w);
#endif
        sum += lights[j].radiance.rgb * seen;
    }
    return sum * colour_at(c.segment, c.along);
}
#endif

// What is shown of a place: light from lights [first, end), or a view of what
// it is made from (of all lights, whatever the range).  at: where its
// transmittances are kept.
vec3 shade_seen(Place c, uint at, uint first, uint end)
{
#if defined(VIEW_FIELD)
    return field(c, at);
#elif defined(VIEW_TANGENT)
    return 0.5 + 0.5 * c.u;
#elif defined(VIEW_COVERAGE)
    return vec3(1.0);
#elif defined(VIEW_STRAND)
    uint h = strand_of[c.segment] * 0x9e3779b9u;
    h = (h ^ (h >> 15)) * 0x85ebca6bu;
    return vec3(uvec3(h, h >> 8, h >> 16) & 255u) / 255.0;
#elif defined(LIT)
    return shade_lit(c, at);
#elif defined(FAST)
    return shade_fast(c, at, first, end);
#else
    return shade(c, at, first, end);
#endif
}
