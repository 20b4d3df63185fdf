#version 450 core
// Tiles that were swept along x have their bytes in the order y, z, x (y
// fastest): here they are put in the order of all others, x, y, z.
// Invocations: a square of 4 x 4 bytes along y and x, one z, a tile.
layout(local_size_x = 8, local_size_y = 8) in;
layout(location = 0) uniform uvec3 size; // voxels
layout(std430, binding = 0) readonly buffer From { uint from[]; };
layout(std430, binding = 1) writeonly buffer To { uint to[]; };

void main()
{
    uvec3 id = uvec3(gl_GlobalInvocationID.xy, gl_WorkGroupID.z % size.z);
    uvec2 words = size.xy >> 2u;
    if (any(greaterThanEqual(id.xy, words)))
        return;
    uint tile = gl_WorkGroupID.z / size.z * words.x * size.y * size.z;
    uint y = tile + id.y + words.y * (id.z + size.z * 4u * id.x);
    uint step = words.y * size.z;
    uvec4 a = uvec4(from[y], from[y + step], from[y + 2u * step],
                    from[y + 3u * step]);
    uint x = tile + id.x + words.x * (4u * id.y + size.y * id.z);
    for (uint k = 0u; k < 4u; k++) {
        uvec4 byte = a >> (8u * k) & 255u;
        to[x + k * words.x] =
            byte.x | byte.y << 8u | byte.z << 16u | byte.w << 24u;
    }
}
