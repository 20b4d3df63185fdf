#version 450 core
// From values to a light's cells: gradient and second derivatives by differences
// between neighbours, packed as lit.glsl reads them.
#include "fast_size.glsl"
#include "fast_bits.glsl"
#define LIT_WRITTEN
#include "lit.glsl"
#include "lit_column.glsl"
layout(local_size_x = 64) in;
layout(binding = 23) uniform samplerBuffer lit_value;
layout(std430, binding = 15) writeonly buffer Cells { uvec4 cells[]; };

vec3 value_of(int column, int phi)
{
    return texelFetch(lit_value, column + max(phi, -phi - 1)).rgb; // even at 0
}

float total(vec3 v) { return v.x + v.y + v.z; }

void main()
{
    LitColumn c = lit_column(gl_WorkGroupID.y, gl_GlobalInvocationID.x);
    if (!c.real)
        return;
    uvec2 range = lit_range(c.at);
    int here = int(c.first), phis = int(c.phis), row = int(LIT_D) * phis;
    // neighbours; at an edge the column itself
    int sm = here - (c.s > 0 ? row : 0), sp = here + (c.s < c.rows - 1 ? row : 0);
    int dm = c.d > 0 ? -phis : 0, dp = c.d < int(LIT_D) - 1 ? phis : 0;
    bool edge = c.d == 0 || c.d == int(LIT_D) - 1; // a straight line
    float slope = edge ? 1.0 : 0.5;
    for (int k = int(range.x); k < int(range.y); k++) {
        bool last = k == phis - 1; // at pi R may have a fold: a parabola
        int back = last ? k - 2 : k - 1, front = last ? k - 1 : k + 1;
        vec3 v = value_of(here, k);
        vec3 s0 = value_of(sm, k), s1 = value_of(sp, k);
        vec3 d0 = value_of(here + dm, k), d1 = value_of(here + dp, k);
        vec3 p0 = value_of(here, back), p1 = value_of(here, front);
        vec3 by_s = 0.5 * (s1 - s0), by_d = slope * (d1 - d0);
        vec3 by_p = last ? 0.5 * (3.0 * v - 4.0 * p1 + p0) : 0.5 * (p1 - p0);
        float f = total(v), per = 1.0 / max(f, 1e-20);
        float ss = 0.5 * total(s0 + s1) - f;
        float dd = edge ? 0.0 : 0.5 * total(d0 + d1) - f;
        float pp = last ? 0.5 * total(v - 2.0 * p1 + p0)
                        : 0.5 * total(p0 + p1) - f;
        float sd = 0.25 * total(value_of(sp + dp, k) - value_of(sp + dm, k) -
                                value_of(sm + dp, k) + value_of(sm + dm, k));
        int up = last ? k : k + 1; // one-sided at the end
        float apart = last ? 0.5 : 0.25;
        float s_p = apart * total(value_of(sp, up) - value_of(sp, k - 1) -
                                  value_of(sm, up) + value_of(sm, k - 1));
        float d_p = apart * total(value_of(here + dp, up) -
                                  value_of(here + dp, k - 1) -
                                  value_of(here + dm, up) +
                                  value_of(here + dm, k - 1));
        uint to = 2u * (c.first + uint(k));
        cells[to] = uvec4(fast_two(v.x, v.y), fast_two(v.z, by_s.x),
                          fast_two(by_s.y, by_s.z), fast_two(by_d.x, by_d.y));
        cells[to + 1u] =
            uvec4(fast_two(by_d.z, by_p.x), fast_two(by_p.y, by_p.z),
                  fast_bf16(clamp(ss * per, -8.0, 8.0)) << 16 |
                      fast_byte_of(dd * per) << 8 | fast_byte_of(pp * per),
                  fast_byte_of(sd * per) << 24 | fast_byte_of(s_p * per) << 16 |
                      fast_byte_of(d_p * per) << 8);
    }
}
