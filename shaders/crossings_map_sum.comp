#version 450 core
// Turns cells into a summed-area table in place: along the rows, where whole
// numbers become floats, then along the columns.  Invocations: a row (or
// column) of a slice.
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec3 size; // side of a slice; slices; 0 rows, 1
                                         // columns
layout(std430, binding = 2) buffer Cells { uint cells[]; };

void main()
{
    uint i = gl_GlobalInvocationID.x, slice = i / size.x, line = i % size.x;
    if (slice >= size.y)
        return;
    uint at = slice * size.x * size.x + line * (size.z == 0u ? size.x : 1u);
    uint step = size.z == 0u ? 1u : size.x;
    float sum = 0.0;
    for (uint n = 0u; n < size.x; n++, at += step) {
        sum += size.z == 0u ? float(cells[at]) * (1.0 / 65536.0)
                            : uintBitsToFloat(cells[at]);
        cells[at] = floatBitsToUint(sum);
    }
}
