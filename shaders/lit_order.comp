#version 450 core
// An order of places in which neighbours have about as many lights that reach
// them directly, so that they leave the loop over those together, and among those
// read the same cells of lights' tables: by the direction of the fibre, seen from
// the eye.  A counting sort in three steps: STEP 0 counts, 1 adds up, 2 puts.
// Within a bin the order is that of threads, on which no radiance depends.
#include "scene.glsl"
#include "cells.glsl"
#include "place.glsl"
#include "lights.glsl"
#include "nodes.glsl"
#define LIT_WRITTEN
#include "lit_size.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint kept;
layout(location = 6) uniform uint lit_places;
layout(std430, binding = 12) writeonly buffer Order { uvec2 order[]; };
layout(std430, binding = 13) buffer Bins { uint bins[]; };
layout(std430, binding = 15) buffer Which { uint bin_of[]; }; // a place's
const uint SIDE = 64u, ALONG = 32u, ACROSS = 16u, REACHED = 8u; // 64^2 in all

#if STEP == 1
shared uint part[64];

// 64 bins an invocation.
void main()
{
    uint i = gl_LocalInvocationID.x, sum = 0u;
    for (uint k = 0u; k < SIDE; k++)
        sum += bins[SIDE * i + k];
    part[i] = sum;
    barrier();
    uint at = 0u;
    for (uint k = 0u; k < i; k++)
        at += part[k];
    for (uint k = 0u; k < SIDE; k++) {
        uint n = bins[SIDE * i + k];
        bins[SIDE * i + k] = at;
        at += n;
    }
}
#else
uint direction(Place c)
{
    vec3 to_eye = normalize(eye.xyz - c.p);
    float along = clamp(dot(to_eye, c.u), -1.0, 1.0);
    float x = dot(c.u, right.xyz) * inversesqrt(dot(right.xyz, right.xyz));
    float y = dot(c.u, up.xyz) * inversesqrt(dot(up.xyz, up.xyz));
    float turn = abs(x) + abs(y) > 0.0 ? atan(y, x) / (2.0 * LIT_PI) + 0.5 : 0.0;
    vec2 side = vec2(float(ALONG), float(ACROSS));
    vec2 at = vec2(0.5 + asin(along) / LIT_PI, turn) * side;
    uvec2 bin = uvec2(clamp(at, vec2(0.0), side - 0.5));
    return bin.y * ALONG + bin.x;
}

uint reached(uint at)
{
    uint n = 0u;
    for (uint j = 0u; j < light_count; j++) {
        uint bits = texelFetch(nodes, int(j * lit_places + at)).x;
        n += unpackUnorm2x16(bits).x >= LIT_LEAST ? 1u : 0u;
    }
    return n * REACHED / (light_count + 1u);
}

void main()
{
    uint row = gl_NumWorkGroups.x * 64u;
    uint at = gl_GlobalInvocationID.x + gl_WorkGroupID.y * row;
    if (at >= lit_places || dispatch.w + at >= list_end[kept])
        return;
#if STEP == 0
    uint bin = direction(place_of(list[dispatch.w + at])) +
               reached(at) * (ALONG * ACROSS);
    bin_of[at] = bin;
    atomicAdd(bins[bin], 1u);
#else
    order[atomicAdd(bins[bin_of[at]], 1u)] = uvec2(at, 0u);
#endif
}
#endif
