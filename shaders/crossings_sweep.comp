#version 450 core
// One slice of every direction of a group: the number of fibres that light
// crosses on its way to each voxel, from that of the slice before it on the
// light's side.  Kept as q = exp(-SHADOW_FALL n), which interpolates better
// than n, and written as bytes.
//
// The group's directions share the axis that they follow most, a; b and c are
// the two across it.  Invocations: four voxels along b, one of c, a few
// directions, which share what is read of the voxels.
#include "shadow_fall.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(location = 0) uniform uvec3 size; // voxels along b, c, a
layout(location = 1) uniform uvec3 to;   // steps of a tile's words: b, c, a
layout(location = 2) uniform uint turn;  // slices done before this one
layout(location = 3) uniform uint count; // directions

struct Way {
    vec3 d;    // direction towards the light: along b, c, a
    uint tile; // where its words begin
};
layout(std140, binding = 1) uniform Ways { Way ways[1024]; };
// rho, rho A_xx, A_yy, A_zz; A_yz, A_zx, A_xy
layout(binding = 0) uniform sampler3D straight;
layout(binding = 1) uniform sampler3D crossed;
// q half a step beyond the voxels of this slice and of the one before, with a
// frame of air
layout(binding = 2) uniform samplerBuffer before;
layout(std430, binding = 0) writeonly buffer State { float state[]; };
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

void sweep(uvec2 cell, uint n, bool up, uint a, vec4 s[4], vec3 x[4])
{
    vec3 d = ways[n].d, w = WORLD(d);
    vec3 squares = w * w, products = 2.0 * w.yzx * w.zxy;

    // One slice towards the light the line is `shift` further.
    float path = 1.0 / abs(d.z), fall = -0.5 * SHADOW_FALL * path;
    vec2 shift = clamp(d.xy * path, -1.0, 1.0);
    vec2 base = min(floor(shift), 0.0), part = shift - base;
    int row = int(size.x) + 2, slice = row * (int(size.y) + 2);
    int inner = (int(cell.y) + 1) * row + int(cell.x) + 1;
    int here = (2 * int(n) + (int(turn) & 1)) * slice + inner;
    int from = (2 * int(n) + (~int(turn) & 1)) * slice + inner +
               int(base.y) * row + int(base.x);

    float left = mix(texelFetch(before, from).x,
                     texelFetch(before, from + row).x, part.y);
    uint four = 0u;
    for (int k = 0; k < 4; k++) {
        float right = mix(texelFetch(before, from + k + 1).x,
                          texelFetch(before, from + k + 1 + row).x, part.y);
        float past = mix(left, right, part.x);
        left = right;
        float half_step = exp(fall * met(s[k], x[k], squares, products));
        float q = max(past * half_step, 1e-6); // denormal floats are slow
        state[here + k] = q * half_step;
        // never 0: as many as a byte can say, not infinitely many
        four |= max(uint(q * 255.0 + 0.5), 1u) << (8 * k);
    }
    words[ways[n].tile + (cell.x >> 2u) * to.x + cell.y * to.y + a * to.z] =
        four;
}

void main()
{
    uvec2 cell = uvec2(4u * gl_GlobalInvocationID.x, gl_GlobalInvocationID.y);
    if (any(greaterThanEqual(cell, size.xy)))
        return;
    // all directions of an invocation go the same way along a
    uint first = gl_WorkGroupID.z * TOGETHER;
    bool up = ways[first].d.z > 0.0; // the light is where a is large
    uint a = up ? size.z - 1u - turn : turn;
    vec4 s[4];
    vec3 x[4];
    for (uint k = 0u; k < 4u; k++) {
        ivec3 at = ivec3(WORLD(uvec3(cell.x + k, cell.y, a)));
        s[k] = texelFetch(straight, at, 0);
        x[k] = texelFetch(crossed, at, 0).xyz;
    }
    for (uint n = first; n < min(first + TOGETHER, count); n++)
        sweep(cell, n, up, a, s, x);
}
