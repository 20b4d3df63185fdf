#version 450 core
// The far table's values at the middles of cells and a cell of ln sigma_f before
// and behind: an invocation a column of Phi.
#include "scene.glsl"
#include "xu.glsl"
#include "dual.glsl"
#include "fast.glsl"
#include "fast_far.glsl"
#define LIT_WRITTEN
#include "lit.glsl"
#include "lit_far_column.glsl"
#include "spread.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 12) writeonly buffer Values { vec4 value[]; };

void main()
{
    LitFarColumn c = lit_far_column(spread_piece() * 64u +
                                    gl_LocalInvocationID.x);
    if (!c.real)
        return;
    Fibre f = Fibre(fibre_eta, fibre_sigma_a, fibre_a,
                    vec3(fibre_alpha_r, fibre_alpha_tt, fibre_alpha_trt),
                    vec3(fibre_beta_r, fibre_beta_tt, fibre_beta_trt), fibre_w_c,
                    fibre_delta_eta);
    DualView view = dual_view(c.theta.x);
    for (int y = 0; y < 3; y++) {
        float sigma = exp(c.log_sigma + float(y - 1) / LIT_FAR_LOG);
        FastFar g = fast_far_of(f, c.theta.x, c.theta.y, sigma * sigma);
        vec3 local = dual_back(view, c.theta.y, vec3(sigma * sigma)) *
                     (fibre_d_b / LIT_PI); // eq 30
        for (int phi = 0; phi < int(LIT_FAR_P); phi++) {
            float across = (float(phi) + 0.5) / LIT_FAR_P;
            vec3 sum = fast_far_at(g, across) + local * (1.0 - across);
            value[3 * (c.first + phi) + y] = vec4(sum, 0.0);
        }
    }
}
