#version 450 core
// Which cells of each column are wanted: those that were marked (lit_mark.comp),
// or all that a pair of directions can reach.
#define LIT_WRITTEN
#include "fast_size.glsl"
#include "lit.glsl"
#include "lit_column.glsl"
layout(local_size_x = 64) in;
layout(binding = 23) uniform usamplerBuffer lit_marks;
layout(std430, binding = 12) writeonly buffer Wanted { uint wanted[]; };
layout(location = 0) uniform uint everything;

bool reached(LitColumn c)
{
    float step = 1.0 / uintBitsToFloat(lit_table[c.table].x);
    float s = (float(c.s) + 0.5) * step - LIT_PI;
    float low = lit_theta_o(float(c.d) / LIT_D) - 0.5 * LIT_PI;
    float high = lit_theta_o(float(c.d + 1) / LIT_D) + 0.5 * LIT_PI;
    return s + 0.51 * step > low && s - 0.51 * step < high;
}

void main()
{
    LitColumn c = lit_column(gl_WorkGroupID.y, gl_GlobalInvocationID.x);
    if (!c.real)
        return;
    uint from = c.phis, to = 0u;
    if (everything != 0u) {
        from = 0u;
        to = reached(c) ? c.phis : 0u;
    }
    for (uint k = 0u; k < (everything != 0u ? 0u : c.phis); k++) {
        bool marked = texelFetch(lit_marks, int(c.first + k)).x != 0u;
        from = marked ? min(from, k) : from;
        to = marked ? k + 1u : to;
    }
    wanted[c.at] = from < to ? from | to << 16 : 0u;
}
