#version 450 core
// The display picture: hair over head over background, exposure, tone curve,
// 8 bits straight alpha.
#include "scene.glsl"
#include "lights.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 9) readonly buffer Sum { vec4 sum[]; };
layout(std430, binding = 10) readonly buffer Head { float head[]; };
layout(std430, binding = 11) writeonly buffer Display { uint display[]; };
layout(location = 0) uniform float inverse_samples;
#ifdef BACKGROUND_SKY
layout(binding = 0) uniform sampler2D sky;
#endif

const float PI = 3.14159265;

// Irradiance of one SRBF light at a normal: exact for a narrow lobe, softened
// at the terminator for a wide one.  Only scenery: no hair reads it.
vec3 head_radiance(vec3 n)
{
    vec3 e = vec3(0.0);
    for (uint j = 0u; j < light_count; j++) {
        float c = dot(n, lights[j].place.xyz);
        float soft = 0.5 * lights[j].place.w;
        float lit = 0.5 * (c + sqrt(c * c + soft * soft)) /
                    sqrt(1.0 + 0.25 * soft * soft);
        e += lights[j].radiance.rgb * lights[j].radiance.w * lit;
    }
    return e * (0.09 / PI); // a dark neutral albedo
}

vec3 ray_of(vec2 pixel)
{
    vec2 ndc = vec2(2.0, -2.0) * (pixel + 0.5) / size.xy + vec2(-1.0, 1.0);
    return normalize(forward.xyz + ndc.x * right.xyz + ndc.y * up.xyz);
}

// Outward normal where the ray meets the head, or at its nearest miss.
vec3 head_normal(vec3 ray)
{
    vec3 o = (eye.xyz - head_centre.xyz) / head_radius.xyz;
    vec3 d = ray / head_radius.xyz;
    float b = dot(o, d), a = dot(d, d), c = dot(o, o) - 1.0;
    float t = (-b - sqrt(max(b * b - a * c, 0.0))) / a;
    return normalize((o + t * d) / head_radius.xyz);
}

vec3 background(vec3 ray)
{
#if defined(BACKGROUND_SKY)
    vec3 d = mat3(sky_to_map) * ray;
    vec2 uv = vec2(0.5 - atan(d.y, d.x) / (2.0 * PI),
                   0.5 - asin(clamp(d.z, -1.0, 1.0)) / PI);
    return textureLod(sky, uv, 0.0).rgb * tint_colour * exp2(tint_exposure);
#else
    return view_colour;
#endif
}

// A filmic shoulder: linear in the darks, 1 at infinity (Hable-like rational
// form fitted here: x (x + .35) / (x (x + .9) + .35), slope 1 at zero).
vec3 curve(vec3 x)
{
    if (view_curve == 1)
        x = x * (x + 0.35) / (x * (x + 0.9) + 0.35);
    x = clamp(x, 0.0, 1.0);
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x,
               lessThanEqual(x, vec3(0.0031308)));
}

void main()
{
    uint row = gl_NumWorkGroups.x * 64u, width = uint(size.x);
    uint at = gl_GlobalInvocationID.x + gl_WorkGroupID.y * row;
    if (at >= width * uint(size.y))
        return;
    vec4 hair = sum[at] * inverse_samples;
    vec3 ray = ray_of(vec2(at % width, at / width));
    vec3 c = hair.rgb;
    float a = hair.a;
    float h = view_head == 1 ? head[at] * inverse_samples : 0.0;
    if (h > 0.0) {
        c += h * head_radiance(head_normal(ray));
        a += h;
    }
#ifndef BACKGROUND_NONE
    c += (1.0 - a) * background(ray);
    a = 1.0;
#endif
    c = a > 0.0 ? c / a : vec3(0.0); // PNG's alpha is straight
    display[at] = packUnorm4x8(vec4(curve(c * exp2(view_exposure)), a));
}
