#version 450 core
// One slice of every direction of a group: the number of fibres that light
// crosses on its way to each voxel, from that of the slice before it on the
// light's side.  Kept as q = exp(-SHADOW_FALL n), which interpolates better
// than n.  What a lookup reads, bytes, four directions a word, is q at the
// voxel's side towards the light: nearer, the voxel holds the strand itself that
// is looked up and what is beside it.  So all directions are looked up at the
// same place.
//
// The group's directions share the axis that they follow most, a; b and c are
// the two across it.  Invocations: four voxels along b, one of c, a few
// directions, which share what is read of the voxels.
#include "shadow_fall.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec3 size; // voxels along b, c, a
layout(location = 1) uniform uvec4 to;   // steps of a tile's words: b, c, a;
                                         // words of a tile
layout(location = 2) uniform uint turn;  // slices done before this one
layout(location = 3) uniform uint count; // directions

// directions towards the light: along b, c, a
layout(std140, binding = 1) uniform Ways { vec4 ways[1024]; };
// rho, rho A_xx, A_yy, A_zz; A_yz, A_zx, A_xy
layout(binding = 0) uniform sampler3D straight;
layout(binding = 1) uniform sampler3D crossed;
// q half a step beyond the voxels of this slice and of the one before, in 16
// bits, four voxels an entry, with a frame of air
layout(binding = 2) uniform usamplerBuffer before;
layout(std430, binding = 0) writeonly buffer State { uvec2 state[]; };
layout(std430, binding = 1) writeonly buffer Bytes { uint words[]; };

#if AXIS == 0 // b, c, a = y, z, x
#define WORLD(v) v.zxy
#elif AXIS == 1 // x, z, y
#define WORLD(v) v.xzy
#else // x, y, z
#define WORLD(v) v.xyz
#endif

// Fibre area that a line along w meets per voxel of its length: the mean of
// sin over the voxel's fibres, taken as the root of the mean of sin^2.
float met(vec4 s, vec3 x, vec3 squares, vec3 products)
{
    float along = dot(s.yzw, squares) + dot(x, products);
    return sqrt(max(s.x * (s.x - along), 0.0));
}

vec4 voxels_of(int entry)
{
    uvec2 two = texelFetch(before, entry).xy;
    return vec4(two.x & 65535u, two.x >> 16u, two.y & 65535u, two.y >> 16u);
}

// What lies behind four voxels: two entries of each of two rows, mixed.
vec4 past_of(int entry, int row, bool lower, vec2 part)
{
    vec4 a = mix(voxels_of(entry), voxels_of(entry + row), part.y);
    vec4 b = mix(voxels_of(entry + 1), voxels_of(entry + 1 + row), part.y);
    vec4 left = lower ? vec4(a.w, b.xyz) : a;
    vec4 right = lower ? b : vec4(a.yzw, b.x);
    return mix(left, right, part.x) * (1.0 / 65535.0);
}

uvec4 sweep(uvec2 cell, uint n, vec4 s[4], vec3 x[4])
{
    vec3 d = ways[n].xyz, w = WORLD(d);
    vec3 squares = w * w, products = 2.0 * w.yzx * w.zxy;

    // One slice towards the light the line is `shift` further.
    float path = 1.0 / abs(d.z), fall = -0.5 * SHADOW_FALL * path;
    vec2 shift = clamp(d.xy * path, -1.0, 1.0);
    vec2 base = min(floor(shift), 0.0), part = shift - base;
    int row = int(size.x >> 2u) + 2, slice = row * (int(size.y) + 2);
    int inner = (int(cell.y) + 1) * row + int(cell.x >> 2u) + 1;
    int here = (2 * int(n) + (int(turn) & 1)) * slice + inner;
    int from = (2 * int(n) + (~int(turn) & 1)) * slice + inner +
               int(base.y) * row + int(base.x);

    vec4 half_step;
    for (int k = 0; k < 4; k++)
        half_step[k] = fall * met(s[k], x[k], squares, products);
    half_step = exp(half_step);
    vec4 past = past_of(from, row, base.x < 0.0, part);
    uvec4 beyond = uvec4(past * half_step * half_step * 65535.0 + 0.5);
    state[here] = beyond.xz | beyond.yw << 16u;
    // never 0: as many as a byte can say, not infinitely many
    return max(uvec4(past * 255.0 + 0.5), uvec4(1u));
}

void main()
{
    uint i = gl_GlobalInvocationID.x, fours = size.x >> 2u;
    uint c = uint((float(i) + 0.5) / float(fours));
    if (c >= size.y)
        return;
    uvec2 cell = uvec2(4u * (i - c * fours), c);
    // all directions of an invocation go the same way along a
    uint first = gl_WorkGroupID.y * TOGETHER;
    bool up = ways[first].z > 0.0; // the light is where a is large
    uint a = up ? size.z - 1u - turn : turn;
    vec4 s[4];
    vec3 x[4];
    for (uint k = 0u; k < 4u; k++) {
        ivec3 at = ivec3(WORLD(uvec3(cell.x + k, cell.y, a)));
        s[k] = texelFetch(straight, at, 0);
        x[k] = texelFetch(crossed, at, 0).xyz;
    }
    uint end = min(first + TOGETHER, count);
    uint at = cell.x * to.x + cell.y * to.y + a * to.z + (first >> 2u) * to.w;
    uvec4 word = uvec4(0u);
    for (uint n = first; n < end; n++) {
        word |= sweep(cell, n, s, x) << (8u * (n & 3u));
        if ((n & 3u) == 3u || n + 1u == end) {
            for (uint k = 0u; k < 4u; k++)
                words[at + k * to.x] = word[k];
            at += to.w;
            word = uvec4(0u);
        }
    }
}
