#version 450 core
// The far table's values at the middles of cells and a cell of ln sigma_f before
// and behind: an invocation a column of Phi.
#include "scene.glsl"
#include "xu.glsl"
#include "dual.glsl"
#include "fast.glsl"
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
    for (int i = 0; i < 3 * int(LIT_FAR_P); i++) {
        int phi = i / 3, y = i - 3 * phi;
        float across = (float(phi) + 0.5) / LIT_FAR_P;
        float sigma = exp(c.log_sigma + float(y - 1) / LIT_FAR_LOG);
        vec3 sigma2 = vec3(sigma * sigma);
        vec3 global = fast_global(f, c.theta.x, c.theta.y, across, sigma2);
        vec3 local = dual_back(view, c.theta.y, sigma2) *
                     ((1.0 - across) * (1.0 / LIT_PI)); // eq 30
        value[3 * c.first + i] = vec4(global + fibre_d_b * local, 0.0);
    }
}
