#version 450 core
// Single places as the tables of each light have them (lit.glsl), through the
// functions that shade the default picture.  In: light, theta_j, Phi, theta_o,
// sigma_f red, green, blue.  Out, each red, green, blue: what comes directly
// (M_R + M_TT + M_TRT + d_b M^L of the light) and what came forward (M^G +
// d_b M^L); both once more from the tables of modes (fast.glsl), of which the
// cells are made; then the cells: s theta_o Phi of the light's table (-1: it has
// none, and modes are read), ln sigma_f s theta_o Phi of the far one, and their
// sizes in the same order.
#include "params.glsl"
#include "xu.glsl"
#include "best.glsl"
#ifdef WITH_MULTIPLE
#include "dual.glsl"
#endif
#include "fast.glsl"
#include "fast_far.glsl"
#include "fast_near.glsl"
#include "fast_grazing.glsl"
#include "lit.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint count;
layout(std430, binding = 0) readonly buffer Cases { float cases[]; };
layout(std430, binding = 1) writeonly buffer Results { float results[]; };
#ifdef GUARDS
layout(std430, binding = 2) buffer Hits { uint hits[]; };
#endif
const uint IN = 7u, OUT = 26u, NEAR_AT = 12u, FAR_AT = 15u, NEAR_SIZE = 19u,
           FAR_SIZE = 22u;

void store(uint at, vec3 v)
{
    results[at] = v.x;
    results[at + 1u] = v.y;
    results[at + 2u] = v.z;
}

Fibre fibre_here()
{
    return Fibre(fibre_eta, fibre_sigma_a, fibre_a,
                 vec3(fibre_alpha_r, fibre_alpha_tt, fibre_alpha_trt),
                 vec3(fibre_beta_r, fibre_beta_tt, fibre_beta_trt), fibre_w_c,
                 fibre_delta_eta);
}

// Indices of s, theta_o and Phi.
vec3 indices(int cell, ivec2 size)
{
    return vec3(cell / (size.x * size.y), cell / size.y % size.x, cell % size.y);
}

// A cell over theta_o, of so many; row: which.
float view_size(float row, float many)
{
    return lit_theta_o((row + 1.0) / many) - lit_theta_o(row / many);
}

vec3 near_modes(Fibre f, Srbf l, float theta_o, float across)
{
    vec3 r, tt, trt;
    fast_modes(f, l, theta_o, across, r, tt, trt);
    if (fast_grazes(theta_o))
        r = fast_grazing_r(f, l, theta_o, across);
    vec3 sum = r + tt + trt;
#ifdef WITH_MULTIPLE
    sum += fibre_d_b * fast_near(dual_view(theta_o), l, cos(LIT_PI * across));
#endif
    return sum;
}

vec3 near_cells(uint to, LitTable light, Srbf l, float theta_o, float across)
{
    float s = theta_o + l.theta, view = lit_view(theta_o);
    int phis = int(light.phis);
    vec3 at = indices(lit_at(lit_place(light, s, view, across),
                             vec2(LIT_D, float(phis))).cell,
                      ivec2(int(LIT_D), phis));
    store(to + NEAR_AT, at);
    store(to + NEAR_SIZE, vec3(1.0 / light.per_s,
                               view_size(at.y, LIT_D), LIT_PI / float(phis)));
    return lit_near(light, s, view, across);
}

#ifdef WITH_MULTIPLE
// Each channel with its own sigma_f; cells are made of one for all, and move.
vec3 far_modes(Fibre f, float theta_j, float theta_o, float across, vec3 sigma)
{
    vec3 sigma2 = sigma * sigma, global = vec3(0.0);
    for (int k = 0; k < 3; k++) {
        FastFar g = fast_far_of(f, theta_o, theta_j, sigma2[k]);
        global[k] = fast_far_at(g, across)[k];
    }
    vec3 local = dual_back(dual_view(theta_o), theta_j, sigma2) *
                 ((1.0 - across) * (1.0 / LIT_PI)); // eq 30
    return global + fibre_d_b * local;
}

vec3 far_cells(uint to, float theta_j, float theta_o, float across, vec3 sigma)
{
    float s = theta_o + theta_j, view = lit_view(theta_o);
    LitFar f = lit_far_here();
    vec3 y = (log(sigma) - f.first) * LIT_FAR_LOG;
    LitFarAt a = lit_far_place(f, s, view, across, y);
    vec3 at = indices(a.at.cell, ivec2(int(LIT_FAR_D), int(LIT_FAR_P)));
    results[to + FAR_AT] = a.slice;
    store(to + FAR_AT + 1u, at);
    results[to + FAR_SIZE] = 1.0 / LIT_FAR_LOG;
    store(to + FAR_SIZE + 1u, vec3(1.0 / a.per_s, view_size(at.y, LIT_FAR_D),
                                   LIT_PI / LIT_FAR_P));
    return lit_far_at(f, s, view, across, log(sigma));
}
#endif

#ifdef GUARDS
float total(vec3 v) { return v.r + v.g + v.b; }

// Nothing counts where less than a hundredth arrives of what the light sends to
// this view from the centre of one lobe or another.  What modes noted is
// forgotten.
void count_cells(Fibre f, Srbf l, float theta_o, vec3 sigma, bool far, vec3 here)
{
    float most = 0.0;
    for (int i = 0; i < 9; i++) {
        Srbf at = Srbf(clamp(2.0 * f.alpha[i / 3] - theta_o, -1.57, 1.57), 0.0,
                       l.lambda);
        float across = 0.5 * float(i % 3);
#ifdef WITH_MULTIPLE
        vec3 sum = far ? far_modes(f, at.theta, theta_o, across, sigma)
                       : near_modes(f, at, theta_o, across);
#else
        vec3 sum = near_modes(f, at, theta_o, across);
#endif
        most = max(most, total(sum));
    }
    for (int k = 0; k < GUARD_WORDS; k++)
        guard_bits[k] = 0u;
    GUARD_LIVE(total(here) > 0.01 * most);
}
#define COUNT_CELLS(f, l, theta_o, sigma, far, here)                           \
    count_cells(f, l, theta_o, sigma, far, here)
#else
#define COUNT_CELLS(f, l, theta_o, sigma, far, here)
#endif

// What was noted since.
void keep_hits(uint i, bool first)
{
#ifdef GUARDS
    for (uint k = 0u; k < uint(GUARD_WORDS); k++)
        hits[uint(GUARD_WORDS) * i + k] =
            guard_bits[k] | (first ? 0u : hits[uint(GUARD_WORDS) * i + k]);
#endif
}

void forget_hits(uint i)
{
#ifdef GUARDS
    for (uint k = 0u; k < uint(GUARD_WORDS); k++)
        hits[uint(GUARD_WORDS) * i + k] = 0u;
#endif
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count)
        return;
    uint at = IN * i, to = OUT * i;
    uvec4 light = lit_light[uint(cases[at])];
    Srbf l = Srbf(cases[at + 1u], 0.0, uintBitsToFloat(light.w));
    float across = xu_across(cases[at + 2u]), theta_o = cases[at + 3u];
    Fibre f = fibre_here();
    vec3 near = near_modes(f, l, theta_o, across);
    store(to + 6u, near);
    uint table = texelFetch(lit_source, int(cases[at])).x;
    if (table != 0u) {
        COUNT_CELLS(f, l, theta_o, vec3(1.0), false, near);
        near = near_cells(to, lit_unpack(table), l, theta_o, across);
        keep_hits(i, true);
    } else {
        store(to + NEAR_AT, vec3(-1.0));
        store(to + NEAR_SIZE, vec3(0.0));
        forget_hits(i);
    }
    store(to, near);
#ifdef WITH_MULTIPLE
    vec3 sigma = vec3(cases[at + 4u], cases[at + 5u], cases[at + 6u]);
    vec3 far = far_modes(f, l.theta, theta_o, across, sigma);
    store(to + 9u, far);
    COUNT_CELLS(f, l, theta_o, sigma, true, far);
    store(to + 3u, far_cells(to, l.theta, theta_o, across, sigma));
    keep_hits(i, false);
#else
    for (uint k = FAR_AT; k < FAR_AT + 4u; k++) {
        results[to + k] = -1.0;
        results[to + k + FAR_SIZE - FAR_AT] = 0.0;
    }
    store(to + 3u, vec3(0.0));
    store(to + 9u, vec3(0.0));
#endif
}
