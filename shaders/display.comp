#version 450 core
// The display picture: hair over head over background, exposure, tone curve,
// 8 bits straight alpha.  An invocation does some pixels of a column: it finds
// what each of them is, then does those of a kind one after the other.
// (A renderer on a CPU runs both sides of a branch, and a loop's body once however
// often it turns: so there is a loop over rows for each kind, and none inside.)
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
layout(location = 2) uniform uvec2 stamp; // of head and sky
#ifdef BACKGROUND_SKY
// The same of the sky that stands behind, before its tint.
layout(std430, binding = 13) buffer Behind { uvec4 behind[]; };
layout(binding = 0) uniform sampler2D sky;
#endif

const float PI = 3.14159265;
const uint ROWS = 16u; // of an invocation; display.c dispatches for so many

// Irradiance of one SRBF light at a normal: exact for a narrow lobe, softened
// at the terminator for a wide one.  Only scenery: no hair reads it.
vec3 head_irradiance(vec3 n)
{
    vec3 e = vec3(0.0);
    for (uint j = 0u; j < light_count; j++) {
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

#ifdef BACKGROUND_SKY
vec3 sky_along(vec3 ray)
{
    vec3 d = mat3(sky_to_map) * ray;
    vec2 uv = vec2(0.5 - atan(d.y, d.x) / (2.0 * PI),
                   0.5 - asin(clamp(d.z, -1.0, 1.0)) / PI);
    return textureLod(sky, uv, 0.0).rgb;
}
#endif

// Behind the hair of a pixel, once it is kept.
vec3 background(uint at)
{
#ifdef BACKGROUND_SKY
    return uintBitsToFloat(behind[at].rgb) * tint_colour * exp2(tint_exposure);
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

// Rows of this invocation's column, a bit each, and its place.
uint next_row(inout uint rows)
{
    uint i = uint(findLSB(rows));
    rows &= rows - 1u;
    return i;
}

void keep_heads(uint rows, uint first, uvec2 place, uint wide)
{
    uint cold = 0u, left = rows;
    while (left != 0u) {
        uint i = next_row(left);
        cold |= kept[first + i * wide].w != stamp.x ? 1u << i : 0u;
    }
    while (cold != 0u) {
        uint i = next_row(cold);
        vec3 ray = ray_of(vec2(place + uvec2(0u, i)));
        vec3 e = head_irradiance(head_normal(ray));
        kept[first + i * wide] = uvec4(floatBitsToUint(e), stamp.x);
    }
}

#ifdef BACKGROUND_SKY
void keep_sky(uint rows, uint first, uvec2 place, uint wide)
{
    uint cold = 0u, left = rows;
    while (left != 0u) {
        uint i = next_row(left);
        cold |= behind[first + i * wide].w != stamp.y ? 1u << i : 0u;
    }
    while (cold != 0u) {
        uint i = next_row(cold);
        vec3 c = sky_along(ray_of(vec2(place + uvec2(0u, i))));
        behind[first + i * wide] = uvec4(floatBitsToUint(c), stamp.y);
    }
}
#endif

void main()
{
    uint x = gl_GlobalInvocationID.x;
    uint y = spread_group(gl_WorkGroupID.y, gl_NumWorkGroups.y) * ROWS;
    uint wide = uint(size.x), high = uint(size.y);
    if (x >= wide || y >= high)
        return;
    uint first = y * wide + x, rows = min(ROWS, high - y);
    uint hairs = 0u, heads = 0u, empty = 0u, through = 0u;
    uint nothing = shown(vec3(0.0), 0.0, view_colour);
    for (uint i = 0u; i < rows; i++) {
        uint at = first + i * wide, s = seen[at];
        bool of_head = view_head == 1 && seen_head(s) > 0u;
        heads |= of_head ? 1u << i : 0u;
        hairs |= !of_head && s >= SEEN_HAIR ? 1u << i : 0u;
#ifdef BACKGROUND_SKY
        empty |= !of_head && s < SEEN_HAIR ? 1u << i : 0u;
        through |= of_head || float(seen_hair(s)) * scale.a < 1.0 ? 1u << i : 0u;
#else
        display[at] = nothing;
#endif
    }
    keep_heads(heads, first, uvec2(x, y), wide);
#ifdef BACKGROUND_SKY
    keep_sky(through, first, uvec2(x, y), wide);
    while (empty != 0u) {
        uint at = first + next_row(empty) * wide;
        display[at] = shown(vec3(0.0), 0.0, background(at));
    }
#endif
    while (hairs != 0u) {
        uint at = first + next_row(hairs) * wide;
        vec4 hair = sum[at] * scale;
        display[at] = shown(hair.rgb, hair.a, background(at));
    }
    while (heads != 0u) {
        uint at = first + next_row(heads) * wide;
        vec4 hair = sum[at] * scale;
        float h = float(seen_head(seen[at])) * scale.w;
        vec3 e = uintBitsToFloat(kept[at].rgb);
        vec3 c = hair.rgb + h * (e * tint.rgb * (0.09 / PI)); // dark and neutral
        display[at] = shown(c, hair.a + h, background(at));
    }
}
