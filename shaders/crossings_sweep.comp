#version 450 core
// One slice of every direction of a group: the number of fibres that light
// crosses on its way to each voxel, from that of the slice before it on the
// light's side.  Kept as q = exp(-SHADOW_FALL n), which interpolates better
// than n.  What a lookup reads, bytes, four directions a word, is q at the
// voxel's side towards the light: nearer, the voxel holds the strand itself that
// is looked up and what is beside it.  So all directions are looked up at the
// same place.
//
// Directions that follow the same axis most, a, and the same way are a group; b
// and c are the two across it.  Invocations: four voxels along b, one of c; a
// chunk, some directions of a group, which share what is read of the voxels.
#include "shadow_fall.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec3 size;  // voxels along x, y, z
layout(location = 1) uniform uint turn;   // slices done before this one
layout(location = 2) uniform uint stride; // entries of a direction's two slices
layout(location = 3) uniform uint axis;

layout(std140, binding = 1) uniform Ways {
    uvec4 chunks[256]; // first slot, end; 1 where the axis is followed up
    vec4 ways[1024];   // towards the light: along b, c, a
};
// rho, rho A_xx, A_yy, A_zz; A_yz, A_zx, A_xy
layout(binding = 0) uniform sampler3D straight;
layout(binding = 1) uniform sampler3D crossed;
// q half a step beyond the voxels of this slice and of the one before, in 16
// bits, four voxels an entry, with a frame of air
layout(binding = 2) uniform usamplerBuffer before;
layout(std430, binding = 0) writeonly buffer State { uvec2 state[]; };
layout(std430, binding = 1) writeonly buffer Bytes { uint words[]; };

// Between x, y, z and b, c, a = y, z, x or x, z, y or x, y, z.
vec3 world_of(vec3 v)
{
    return axis == 0u ? v.zxy : axis == 1u ? v.xzy : v;
}

uvec3 across_of(uvec3 v)
{
    return axis == 0u ? v.yzx : axis == 1u ? v.xzy : v;
}

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

struct Place {
    uvec3 dims;  // voxels along b, c, a
    int inner;   // entry of the four voxels in a slice
    vec4 s[4];
    vec3 x[4];
};

uvec4 sweep(Place p, uint n)
{
    vec3 d = ways[n].xyz, w = world_of(d);
    vec3 squares = w * w, products = 2.0 * w.yzx * w.zxy;

    // One slice towards the light the line is `shift` further.
    float path = 1.0 / abs(d.z), fall = -0.5 * SHADOW_FALL * path;
    vec2 shift = clamp(d.xy * path, -1.0, 1.0);
    vec2 base = min(floor(shift), 0.0), part = shift - base;
    int row = int(p.dims.x >> 2u) + 2, slice = row * (int(p.dims.y) + 2);
    int here = int(n * stride) + (int(turn) & 1) * slice + p.inner;
    int from = int(n * stride) + (~int(turn) & 1) * slice + p.inner +
               int(base.y) * row + int(base.x);

    vec4 step_of;
    for (int k = 0; k < 4; k++)
        step_of[k] = 2.0 * fall * met(p.s[k], p.x[k], squares, products);
    vec4 past = past_of(from, row, base.x < 0.0, part);
    uvec4 beyond = uvec4(past * exp(step_of) * 65535.0 + 0.5);
    state[here] = beyond.xz | beyond.yw << 16u;
    // never 0: as many as a byte can say, not infinitely many
    return max(uvec4(past * 255.0 + 0.5), uvec4(1u));
}

void main()
{
    uvec4 chunk = chunks[gl_WorkGroupID.y];
    Place p;
    p.dims = across_of(size);
    uint i = gl_GlobalInvocationID.x, fours = p.dims.x >> 2u;
    uint c = uint((float(i) + 0.5) / float(fours));
    if (c >= p.dims.y)
        return;
    uint b = i - c * fours; // four voxels
    p.inner = int((c + 1u) * (fours + 2u) + b + 1u);
    // where it is followed up the light is where a is large
    uint a = chunk.z != 0u ? p.dims.z - 1u - turn : turn;
    for (uint k = 0u; k < 4u; k++) {
        ivec3 at = ivec3(world_of(vec3(4u * b + k, c, a)));
        p.s[k] = texelFetch(straight, at, 0);
        p.x[k] = texelFetch(crossed, at, 0).xyz;
    }
    // a voxel's texel is four words, of four slots each
    uvec3 to = 4u * across_of(uvec3(1u, size.x, size.x * size.y));
    uint bank = 4u * size.x * size.y * size.z;
    uint voxel = 4u * b * to.x + c * to.y + a * to.z;
    uvec4 word = uvec4(0u);
    for (uint n = chunk.x; n < chunk.y; n++) {
        word |= sweep(p, n) << (8u * (n & 3u));
        if ((n & 3u) == 3u || n + 1u == chunk.y) {
            uint at = voxel + (n >> 4u) * bank + (n >> 2u & 3u);
            for (uint k = 0u; k < 4u; k++)
                words[at + k * to.x] = word[k];
            word = uvec4(0u);
        }
    }
}
