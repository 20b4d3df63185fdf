#version 450 core
// Single integrals of dual scattering through the functions that shade a
// picture.  All cases are of one fibre, whose tables are bound; in: lambda_j
// theta_j phi_j theta_o phi_o and sigma_f red, green, blue, or theta_d Phi.
//   PROBE_HALF        out: N^G_R N^G_TT N^G_TRT
//   else              out: M^G_R M^G_TT M^G_TRT M^L M^L of the light itself,
//                          each red, green, blue
#include "xu.glsl"
#include "dual.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint count;
layout(location = 1) uniform float fibre[13];
layout(std430, binding = 0) readonly buffer Cases { float cases[]; };
layout(std430, binding = 1) writeonly buffer Results { float results[]; };
#ifdef GUARDS
layout(std430, binding = 2) writeonly buffer Hits { uint hits[]; };
#endif

void store(uint at, vec3 v)
{
    results[at] = v.x;
    results[at + 1u] = v.y;
    results[at + 2u] = v.z;
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count)
        return;
    Fibre f = Fibre(fibre[0], vec3(fibre[1], fibre[2], fibre[3]), fibre[4],
                    vec3(fibre[5], fibre[6], fibre[7]),
                    vec3(fibre[8], fibre[9], fibre[10]), fibre[11], fibre[12]);
#ifdef PROBE_HALF
    store(3u * i, dual_half(f, cases[2u * i], cases[2u * i + 1u]));
#else
    uint at = 8u * i;
    Srbf l = Srbf(cases[at + 1u], cases[at + 2u], cases[at]);
    DualView v = dual_view(cases[at + 3u]);
    vec3 sigma = vec3(cases[at + 5u], cases[at + 6u], cases[at + 7u]), g, ml, mld;
    dual_modes(f, v, l, cases[at + 4u], sigma, vec3(1, 0, 0), g, ml, mld);
    store(15u * i, g);
    dual_modes(f, v, l, cases[at + 4u], sigma, vec3(0, 1, 0), g, ml, mld);
    store(15u * i + 3u, g);
    dual_modes(f, v, l, cases[at + 4u], sigma, vec3(0, 0, 1), g, ml, mld);
    store(15u * i + 6u, g);
    store(15u * i + 9u, ml);
    store(15u * i + 12u, mld);
#endif
#ifdef GUARDS
    for (uint k = 0u; k < uint(GUARD_WORDS); k++)
        hits[uint(GUARD_WORDS) * i + k] = guard_bits[k];
#endif
}
