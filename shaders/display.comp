#version 450 core
// The display picture: hair over head over background, exposure, tone curve,
// 8 bits straight alpha.  An invocation does some pixels of a column: all as if
// nothing were seen there, then again those that see hair before a plain
// background, then those where more is seen.
// (A renderer on a CPU runs both sides of a branch, but a loop's turns only
// where there are any.)
#include "scene.glsl"
#include "lights.glsl"
#include "seen.glsl"
#include "spread.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 9) readonly buffer Sum { vec4 sum[]; };
layout(std430, binding = 10) readonly buffer Seen { uint seen[]; };
layout(std430, binding = 11) writeonly buffer Display { uint display[]; };
// What the lights make of the head, rgb, where `w` is `stamp`: they, the head and
// the camera are as they were when it was made.
layout(std430, binding = 12) buffer Kept { uvec4 kept[]; };
layout(location = 0) uniform vec4 scale; // of sum: rgb the sky's tint / samples
layout(location = 1) uniform vec4 tint;  // rgb of the sky's light; w: exposure
layout(location = 2) uniform uint stamp;
#ifdef BACKGROUND_SKY
layout(binding = 0) uniform sampler2D sky;
#endif

const float PI = 3.14159265;
const uint ROWS = 16u; // of an invocation; display.c dispatches for so many

// Irradiance of one SRBF light at a normal: exact for a narrow lobe, softened
// at the terminator for a wide one.  Only scenery: no hair reads it.
// e: the sum over the lights before `from`.
vec3 head_irradiance(vec3 n, uint from, vec3 e)
{
    for (uint j = from; j < light_count; j++) {
        float c = dot(n, lights[j].place.xyz);
        float soft = 0.5 * lights[j].place.w;
        float lit = 0.5 * (c + sqrt(c * c + soft * soft)) /
                    sqrt(1.0 + 0.25 * soft * soft);
        e += lights[j].radiance.rgb * lights[j].radiance.w * lit;
    }
    return e;
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
    x = min(x, 1e9); // white; the square of more may be infinite
    if (view_curve == 1)
        x = x * (x + 0.35) / (x * (x + 0.9) + 0.35);
    x = clamp(x, 0.0, 1.0);
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x,
               lessThanEqual(x, vec3(0.0031308)));
}

// behind: seen where a is less than one.
uint shown(vec3 c, float a, vec3 behind)
{
#ifndef BACKGROUND_NONE
    c += (1.0 - a) * behind;
    a = 1.0;
#endif
    c = a > 0.0 ? c / a : vec3(0.0); // PNG's alpha is straight
    return packUnorm4x8(vec4(curve(c * tint.w), a));
}

void main()
{
    uint x = gl_GlobalInvocationID.x;
    uint y = spread_group(gl_WorkGroupID.y, gl_NumWorkGroups.y) * ROWS;
    uint wide = uint(size.x), high = uint(size.y);
    if (x >= wide || y >= high)
        return;
    uint first = y * wide + x, rows = min(ROWS, high - y);
    uint hairs = 0u, more = 0u, nothing = shown(vec3(0.0), 0.0, view_colour);
    for (uint i = 0u; i < rows; i++) {
        uint at = first + i * wide, s = seen[at];
        bool again = view_head == 1 && seen_head(s) > 0u;
#ifdef BACKGROUND_SKY
        again = again || float(seen_hair(s)) * scale.a < 1.0;
#endif
        more |= again ? 1u << i : 0u;
        hairs |= !again && s >= SEEN_HAIR ? 1u << i : 0u;
        display[at] = nothing;
    }
    while (hairs != 0u) {
        uint at = first + uint(findLSB(hairs)) * wide;
        hairs &= hairs - 1u;
        vec4 hair = sum[at] * scale;
        display[at] = shown(hair.rgb, hair.a, view_colour);
    }
    while (more != 0u) {
        uint i = uint(findLSB(more)), at = first + i * wide;
        more &= more - 1u;
        vec4 hair = sum[at] * scale;
        float h = view_head == 1 ? float(seen_head(seen[at])) * scale.w : 0.0;
        vec3 ray = ray_of(vec2(x, y + i)), e = vec3(0.0);
        for (uint k = h > 0.0 ? 0u : 1u; k < 1u; k++) {
            uvec4 old = kept[at];
            uint from = old.w == stamp ? light_count : 0u;
            e = from > 0u ? uintBitsToFloat(old.rgb) : vec3(0.0);
            e = head_irradiance(head_normal(ray), from, e);
            kept[at] = uvec4(floatBitsToUint(e), stamp);
        }
        vec3 c = hair.rgb + h * (e * tint.rgb * (0.09 / PI)); // dark and neutral
        display[at] = shown(c, hair.a + h, background(ray));
    }
}
