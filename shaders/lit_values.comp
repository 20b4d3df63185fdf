#version 450 core
// Values at the middles of a light's cells: an invocation a column of Phi, of as
// much of it as cells are wanted here or beside it.
#include "scene.glsl"
#include "xu.glsl"
#include "best.glsl"
#ifdef WITH_MULTIPLE
#include "dual.glsl"
#endif
#include "fast.glsl"
#include "fast_near.glsl"
#include "fast_grazing.glsl"
#define LIT_WRITTEN
#include "lit.glsl"
#include "lit_column.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 12) buffer Values { vec4 value[]; };

Fibre fibre_here()
{
    return Fibre(fibre_eta, fibre_sigma_a, fibre_a,
                 vec3(fibre_alpha_r, fibre_alpha_tt, fibre_alpha_trt),
                 vec3(fibre_beta_r, fibre_beta_tt, fibre_beta_trt), fibre_w_c,
                 fibre_delta_eta);
}

void main()
{
    LitColumn c = lit_column(gl_WorkGroupID.y, gl_GlobalInvocationID.x);
    if (!c.real)
        return;
    uvec2 range = lit_reach(c);
    vec2 theta = lit_theta(c);
    Fibre f = fibre_here();
    Srbf lobe = Srbf(theta.y, 0.0, uintBitsToFloat(lit_table[c.table].w));
    FastLong g = fast_long(f, lobe, theta.x);
#ifdef WITH_MULTIPLE
    FastNear near = fast_near_of(dual_view(theta.x), lobe);
#endif
    bool grazes = fast_grazes(theta.x);
    float step = 1.0 / float(c.phis);
    // R seen along the fibre: a loop of its own, see shade_fast.glsl
    for (uint k = range.x; k < (grazes ? range.y : range.x); k++) {
        vec3 r = fast_grazing_r(f, lobe, theta.x, (float(k) + 0.5) * step);
        value[c.first + k] = vec4(r, 0.0);
    }
    for (uint k = range.x; k < range.y; k++) {
        float across = (float(k) + 0.5) * step;
        vec3 r, tt, trt;
        fast_modes_at(g, across, r, tt, trt);
        if (grazes)
            r = value[c.first + k].rgb;
        vec3 sum = r + tt + trt;
#ifdef WITH_MULTIPLE
        sum += fibre_d_b * fast_near_at(near, cos(LIT_PI * across));
#endif
        value[c.first + k] = vec4(sum, 0.0);
    }
}
