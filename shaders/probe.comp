#version 450 core
// Single integrals: fifteen numbers in, M_R M_TT M_TRT out, through the very
// functions that shade a picture.  Cases of the other kind of fibre (circular,
// eccentric) are left to the other variant of this program.  XU_BEST: the fibre
// whose lobes are bound has the cases from `first` on.
#include "xu.glsl"
#ifdef XU_BEST
#include "best.glsl"
#endif
layout(local_size_x = 64) in;
layout(location = 0) uniform uint count;
layout(location = 1) uniform float delta_eta;
layout(location = 2) uniform uint first;
layout(std430, binding = 0) readonly buffer Cases { float cases[]; };
layout(std430, binding = 1) writeonly buffer Results { float results[]; };
#ifdef GUARDS
layout(std430, binding = 2) writeonly buffer Hits { uint hits[]; };
#endif

void main()
{
    uint i = first + gl_GlobalInvocationID.x, at = 15u * i;
    if (i >= first + count)
        return;
#ifdef XU_ECCENTRIC
    if (cases[at + 9u] == 1.0)
        return;
#else
    if (cases[at + 9u] != 1.0)
        return;
#endif
    Fibre f;
    f.eta = cases[at];
    f.sigma_a = vec3(cases[at + 1u]);
    f.alpha = vec3(cases[at + 2u], cases[at + 3u], cases[at + 4u]);
    f.beta = vec3(cases[at + 5u], cases[at + 6u], cases[at + 7u]);
    f.w_c = cases[at + 8u];
    f.a = cases[at + 9u];
    f.delta_eta = delta_eta;
    Srbf l = Srbf(cases[at + 11u], cases[at + 12u], cases[at + 10u]);
    vec3 r, tt, trt;
#ifdef XU_BEST
    best_modes(f, best_fibre(), l, cases[at + 13u], cases[at + 14u], r, tt, trt);
#else
    xu_modes(f, l, cases[at + 13u], cases[at + 14u], r, tt, trt);
#endif
    results[3u * i] = r.x;
    results[3u * i + 1u] = tt.x;
    results[3u * i + 2u] = trt.x;
#ifdef GUARDS
    for (uint k = 0u; k < uint(GUARD_WORDS); k++)
        hits[uint(GUARD_WORDS) * i + k] = guard_bits[k];
#endif
}
