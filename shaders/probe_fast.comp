#version 450 core
// Single integrals from the tables of one fibre (fast.glsl), through the
// functions that shade a picture.  In: lambda_j theta_j phi_j theta_o phi_o and
// sigma_f red, green, blue; out: M_R M_TT M_TRT M^G_R M^G_TT M^G_TRT, each red,
// green, blue.
#include "xu.glsl"
#include "fast.glsl"
#include "best.glsl"
#include "fast_grazing.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint count;
layout(location = 1) uniform float fibre[13];
layout(std430, binding = 0) readonly buffer Cases { float cases[]; };
layout(std430, binding = 1) writeonly buffer Results { float results[]; };

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
    uint at = 8u * i;
    Srbf l = Srbf(cases[at + 1u], cases[at + 2u], cases[at]);
    float theta_o = cases[at + 3u], across = xu_across(cases[at + 4u] - l.phi);
    vec3 sigma = vec3(cases[at + 5u], cases[at + 6u], cases[at + 7u]), r, tt, trt;
    fast_modes(f, l, theta_o, across, r, tt, trt);
    if (fast_grazes(theta_o))
        r = fast_grazing_r(f, l, theta_o, across);
    store(18u * i, r);
    store(18u * i + 3u, tt);
    store(18u * i + 6u, trt);
    fast_globals(f, theta_o, l.theta, across, sigma * sigma, r, tt, trt);
    store(18u * i + 9u, r);
    store(18u * i + 12u, tt);
    store(18u * i + 15u, trt);
}
