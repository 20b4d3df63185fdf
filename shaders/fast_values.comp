#version 450 core
// The inner integrals (Xu 2011, eq 12 and 28) at the middles of the tables'
// cells: cosine series in Phi.  A light multiplies the coefficients of a fibre
// by those of its circular Gaussian.  Four Phi an invocation.
#include "fast_size.glsl"
#include "spread.glsl"
layout(local_size_x = 64) in;
layout(binding = 17) uniform samplerBuffer coefficient;
layout(binding = 18) uniform samplerBuffer factor;
layout(binding = 19) uniform samplerBuffer cosine;
layout(std430, binding = 0) writeonly buffer Values { vec4 value[]; };
layout(location = 0) uniform uint terms; // of the fibre's series
const uint QUADS = uint(FAST_P) / 4u, D = uint(FAST_D);
const uint FACTORS = 64u; // a slice's: their number comes after them

void main()
{
    uint i = spread_piece() * 64u + gl_LocalInvocationID.x;
    if (i >= FAST_CELLS / 4u)
        return;
    uint quad = i % QUADS, d = i / QUADS % D, slice = i / (QUADS * D);
    uint from = slice * (FACTORS + 1u);
    uint end = min(terms, uint(texelFetch(factor, int(from + FACTORS)).x));
    vec4 r = vec4(0.0), tt0 = r, tt1 = r, tt2 = r, trt0 = r, trt1 = r, trt2 = r;
    for (uint n = 0u; n < end; n++) {
        vec4 a = texelFetch(coefficient, int(2u * (d * terms + n)));
        vec4 b = texelFetch(coefficient, int(2u * (d * terms + n) + 1u));
        vec4 c = texelFetch(factor, int(from + n)).x *
                 texelFetch(cosine, int(n * QUADS + quad));
        tt0 += a.x * c;
        tt1 += a.y * c;
        tt2 += a.z * c;
        r += a.w * c;
        trt0 += b.x * c;
        trt1 += b.y * c;
        trt2 += b.z * c;
    }
    uint to = 8u * i;
    for (int k = 0; k < 4; k++) {
        value[to + 2u * uint(k)] = vec4(tt0[k], tt1[k], tt2[k], r[k]);
        value[to + 2u * uint(k) + 1u] = vec4(trt0[k], trt1[k], trt2[k], 0.0);
    }
}
