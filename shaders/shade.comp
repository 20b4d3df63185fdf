#version 450 core
// Radiance of the cells that this sample sees for the first time: all lights
// in the inner loop (Xu 2011, eq 2, with the fibre's diameter cancelled: a
// strand drawn as a ribbon of its own width has radiance = curve intensity /
// diameter).
#include "scene.glsl"
#include "cells.glsl"
#include "lights.glsl"
#include "xu.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint kept;

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

// u along the fibre; v across it: the major axis of an eccentric fibre, else
// towards the viewer, which makes phi_o zero.
void frame_of(uint i, float t, vec3 to_eye, out vec3 u, out vec3 v)
{
    vec3 sum = mix(tangent_at(i), tangent_at(i + 1u), t);
    float n = dot(sum, sum);
    u = n > 1e-12 ? sum * inversesqrt(n) : tangent_at(i);
    vec3 side = to_eye;
#ifdef XU_ECCENTRIC
    side = mix(unpack_axis(axis_of[i]), unpack_axis(axis_of[i + 1u]), t);
#endif
    v = side - dot(side, u) * u;
    n = dot(v, v);
    if (n < 1e-10) { // looking along the fibre: any direction will do
        side = abs(u.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
        v = side - dot(side, u) * u;
        n = dot(v, v);
    }
    v *= inversesqrt(n);
}

float azimuth(vec3 d, vec3 v, vec3 w)
{
    float x = dot(d, v), y = dot(d, w);
    return abs(x) + abs(y) > 0.0 ? atan(y, x) : 0.0;
}

void main()
{
    uint begin = dispatch.w, at = begin + gl_GlobalInvocationID.x;
    if (at >= list_end[kept])
        return;
    uint slot = list[at], key = keys[slot] - 1u;
    uint i = key >> CELL_BITS, cell = key & (CELLS_MAX - 1u);
    float t = (float(cell) + 0.5) / float(cell_count(i));
    vec3 p = mix(points[i].xyz, points[i + 1u].xyz, t);
    vec3 to_eye = normalize(eye.xyz - p), u, v;
    frame_of(i, t, to_eye, u, v);
    vec3 w = cross(u, v);
    float theta_o = special_asin(dot(to_eye, u));
    float phi_o = azimuth(to_eye, v, w);

    Fibre fibre = Fibre(fibre_eta, fibre_sigma_a, fibre_a,
                        vec3(fibre_alpha_r, fibre_alpha_tt, fibre_alpha_trt),
                        vec3(fibre_beta_r, fibre_beta_tt, fibre_beta_trt),
                        fibre_w_c, fibre_delta_eta);
    vec3 sum = vec3(0.0);
    for (uint j = 0u; j < light_count; j++) {
        vec4 place = lights[j].place;
        Srbf light = Srbf(special_asin(dot(place.xyz, u)),
                          azimuth(place.xyz, v, w), place.w);
        vec3 r, tt, trt;
        xu_modes(fibre, light, theta_o, phi_o, r, tt, trt);
        sum += lights[j].radiance.rgb *
               (mask.x * r + mask.y * tt + mask.z * trt);
    }
    radiance[slot] = vec4(sum * colour_at(i, t), 1.0);
}
