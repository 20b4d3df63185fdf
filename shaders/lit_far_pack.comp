#version 450 core
// From the far table's values to its cells, as lit_pack.comp.
#include "fast_size.glsl"
#include "fast_bits.glsl"
#define LIT_WRITTEN
#include "lit.glsl"
#include "lit_far_column.glsl"
#include "spread.glsl"
layout(local_size_x = 64) in;
layout(binding = 23) uniform samplerBuffer lit_value;
layout(std430, binding = 15) writeonly buffer Cells { uvec4 cells[]; };

// y: -1, 0, 1 along ln sigma_f.
vec3 value_of(int column, int phi, int y)
{
    return texelFetch(lit_value, 3 * (column + phi) + y + 1).rgb;
}

float total(vec3 v) { return v.x + v.y + v.z; }

uint bytes(float a, float b, float c, float d)
{
    return fast_byte_of(a) << 24 | fast_byte_of(b) << 16 |
           fast_byte_of(c) << 8 | fast_byte_of(d);
}

uint bytes(vec3 v, float d) { return bytes(v.x, v.y, v.z, d); }

void main()
{
    LitFarColumn c = lit_far_column(spread_piece() * 64u +
                                    gl_LocalInvocationID.x);
    if (!c.real)
        return;
    const int P = int(LIT_FAR_P), D = int(LIT_FAR_D), row = D * P;
    int here = c.first;
    int sm = here - (c.s > 0 ? row : 0), sp = here + (c.s < c.rows - 1 ? row : 0);
    int dm = here - (c.d > 0 ? P : 0), dp = here + (c.d < D - 1 ? P : 0);
    int dms = sm + dm - here, dps = sm + dp - here;
    int dmq = sp + dm - here, dpq = sp + dp - here;
    bool edge = c.d == 0 || c.d == D - 1; // a straight line
    float slope = edge ? 1.0 : 0.5;
    for (int k = 0; k < P; k++) {
        // the local part has an edge at 0 and pi: parabolas there
        int mid = clamp(k, 1, P - 2);
        float off = float(k - mid); // -1, 0, 1
        vec3 v = value_of(here, k, 0);
        vec3 s0 = value_of(sm, k, 0), s1 = value_of(sp, k, 0);
        vec3 d0 = value_of(dm, k, 0), d1 = value_of(dp, k, 0);
        vec3 y0 = value_of(here, k, -1), y1 = value_of(here, k, 1);
        vec3 p0 = value_of(here, mid - 1, 0), p1 = value_of(here, mid, 0);
        vec3 p2 = value_of(here, mid + 1, 0);
        vec3 by_s = 0.5 * (s1 - s0), by_d = slope * (d1 - d0), by_y = 0.5 * (y1 - y0);
        vec3 bend = p0 - 2.0 * p1 + p2, by_p = 0.5 * (p2 - p0) + off * bend;
        float f = total(v), per = 1.0 / max(f, 1e-20);
        float ss = 0.5 * total(s0 + s1) - f, dd = edge ? 0.0 : 0.5 * total(d0 + d1) - f;
        float yy = 0.5 * total(y0 + y1) - f, pp = 0.5 * total(bend);
        float sd = 0.25 * total(value_of(dpq, k, 0) - value_of(dmq, k, 0) -
                                value_of(dps, k, 0) + value_of(dms, k, 0));
        float s_p = 0.25 * total(value_of(sp, mid + 1, 0) - value_of(sp, mid - 1, 0) -
                                 value_of(sm, mid + 1, 0) + value_of(sm, mid - 1, 0));
        float d_p = 0.25 * total(value_of(dp, mid + 1, 0) - value_of(dp, mid - 1, 0) -
                                 value_of(dm, mid + 1, 0) + value_of(dm, mid - 1, 0));
        float sy = 0.25 * total(value_of(sp, k, 1) - value_of(sp, k, -1) -
                                value_of(sm, k, 1) + value_of(sm, k, -1));
        float dy = 0.25 * total(value_of(dp, k, 1) - value_of(dp, k, -1) -
                                value_of(dm, k, 1) + value_of(dm, k, -1));
        float py = 0.25 * total(value_of(here, mid + 1, 1) - value_of(here, mid + 1, -1) -
                                value_of(here, mid - 1, 1) + value_of(here, mid - 1, -1));
        vec3 one = 1.0 / max(v, 1e-20);
        uint to = lit_from.x + 2u * uint(here + k);
        cells[to] = uvec4(fast_two(v.x, v.y),
                          fast_two(v.z, clamp(ss * per, -8.0, 8.0)),
                          bytes(by_s * one, dd * per), bytes(by_d * one, pp * per));
        cells[to + 1u] = uvec4(bytes(by_p * one, sd * per),
                               bytes(by_y * one, s_p * per),
                               bytes(d_p * per, sy * per, dy * per, py * per),
                               bytes(yy * per, 0.0, 0.0, 0.0));
    }
}
