// dual.glsl - multiple scattering of one light at one fibre (Zinke 2008; Xu
// 2011, section 4.3), for the light that was scattered forward on its way and
// for what turns back in the hair around.  Include after xu.glsl.
//
//   dual_forward(theta_j)         what one crossing does to light from theta_j
//   dual_view(theta_o)            once a view: S_back as it is seen from there
//   dual_modes(f, view, l, ...)   M^G, M^L and M^L of the light itself
//
// Without T_f, solid angle, amplitude, d_f, d_b.  M^G and M^L have psi_f of eq 5
// (1/cos theta_i), normalised over its half circle.  Tables and series:
// renderer/dual_tables.h; formulas: docs/METHODS.md, section 2.
//
// Variants: DUAL_PAPER (dual_paper.glsl), XU_NO_TT_TRT.  XU_ECCENTRIC changes
// nothing here: tables and series are of the mean index.
// Finite and >= 0 for every legal parameter, lambda_j >= 1e-3, sigma_f >= 1e-3.
// Loops are written out: a loop inside the loop over lights costs a CPU renderer
// more than its turns do, and a texture fetch as much as 300 multiplications.

layout(binding = 3) uniform sampler1DArray dual_table; // over an inclination

struct DualAt { // of one forward scattering event, for each colour channel
    vec3 a_f;       // attenuation
    vec3 betabar2_f; // variance in theta_h; theta gets four times that
};

vec3 dual_layer(float theta, int layer)
{
    float size = float(textureSize(dual_table, 0).x);
    float at = (theta * (1.0 / XU_PI) + 0.5) * (size - 1.0) + 0.5;
    return textureLod(dual_table, vec2(at / size, float(layer)), 0.0).rgb;
}

DualAt dual_forward(float theta_j)
{
    return DualAt(dual_layer(theta_j, 0), dual_layer(theta_j, 1));
}

// Share of a circular Gaussian of concentration kappa that falls into half a
// circle, cos_phi the cosine of the angle between their centres: 1/2 + 1/2
// erf(u), u ~ cos_phi for a wide Gaussian, ~ sin of half the angle from the edge
// for a narrow one.  Its slope at the edge is right for every kappa; elsewhere
// within 7e-3.
float dual_half_share(float kappa, float i0e, float cos_phi)
{
    float slope = 0.282094792 * (1.0 - exp(-2.0 * kappa)) / i0e;
    float narrow = kappa * kappa / (7.6 + 0.66 * kappa);
    float c = sqrt(0.5 + 0.5 * sqrt(max(1.0 - cos_phi * cos_phi, 0.0)));
    float t = slope * cos_phi * (narrow / c + 1.0) / (1.0 + narrow);
    float rest = special_erfc(vec2(t), exp(vec2(-t * t))).x;
    return t > 0.0 ? 1.0 - 0.5 * rest : 0.5 * rest;
}

#ifdef DUAL_PAPER
#include "dual_paper.glsl"
#else

layout(std140, binding = 6) uniform Dual {
    vec4 dual_index;    // eta^2 - 1, 2 eta, F_0
    vec4 dual_wave[48]; // [12 harmonics]: TT; R; TRT, TRT
    vec4 dual_near[32]; // [4 waves][8 powers]: TT red, green, blue; R
    vec4 dual_far[54];  // [6 waves][9 powers]: TRT red, green, blue
};

// --- a view -----------------------------------------------------------------
// What does not change from light to light: S_back cos theta_i as it is seen from
// one theta_o, without its azimuth, which in theta_i is a Gaussian with two
// Hermite terms; and the block above, since a value of it costs more than a
// multiplication inside the loop over lights.
struct DualView {
    float theta_o;
    vec3 mass, centre, width2, skew, peak;
    vec4 wave[48], near[32];
    vec3 far[54];
};

#define DUAL_LOAD_3(to, from, i, part)                                         \
    to[i] = from[i] part;                                                      \
    to[i + 1] = from[i + 1] part;                                              \
    to[i + 2] = from[i + 2] part
#define DUAL_LOAD_9(to, from, i, part)                                         \
    DUAL_LOAD_3(to, from, i, part);                                            \
    DUAL_LOAD_3(to, from, i + 3, part);                                        \
    DUAL_LOAD_3(to, from, i + 6, part)

DualView dual_view(float theta_o)
{
    DualView v;
    v.theta_o = theta_o;
    v.mass = dual_layer(theta_o, 2);
    v.centre = dual_layer(theta_o, 3);
    v.width2 = dual_layer(theta_o, 4);
    v.skew = dual_layer(theta_o, 5);
    v.peak = dual_layer(theta_o, 6);
    DUAL_LOAD_9(v.wave, dual_wave, 0, );
    DUAL_LOAD_9(v.wave, dual_wave, 9, );
    DUAL_LOAD_9(v.wave, dual_wave, 18, );
    DUAL_LOAD_9(v.wave, dual_wave, 27, );
    DUAL_LOAD_9(v.wave, dual_wave, 36, );
    DUAL_LOAD_3(v.wave, dual_wave, 45, );
    DUAL_LOAD_9(v.near, dual_near, 0, );
    DUAL_LOAD_9(v.near, dual_near, 9, );
    DUAL_LOAD_9(v.near, dual_near, 18, );
    DUAL_LOAD_3(v.near, dual_near, 27, );
    v.near[30] = dual_near[30];
    v.near[31] = dual_near[31];
    DUAL_LOAD_9(v.far, dual_far, 0, .rgb);
    DUAL_LOAD_9(v.far, dual_far, 9, .rgb);
    DUAL_LOAD_9(v.far, dual_far, 18, .rgb);
    DUAL_LOAD_9(v.far, dual_far, 27, .rgb);
    DUAL_LOAD_9(v.far, dual_far, 36, .rgb);
    DUAL_LOAD_9(v.far, dual_far, 45, .rgb);
    return v;
}

// --- N^G (eq 28) ------------------------------------------------------------
// The series of dual_azimuth.h at one Phi: a polynomial of theta_d is left.
struct DualSeries {
    vec4 n0, n1, n2, n3, n4, n5, n6, n7;     // TT red, green, blue; R
    vec3 f0, f1, f2, f3, f4, f5, f6, f7, f8; // TRT
};

// What a harmonic adds to the waves of R and TT, and to those of TRT.
#define DUAL_BOTH(k, c)                                                        \
    tt += c * v.wave[4 * k];                                                   \
    r += c * v.wave[4 * k + 1].xyz;                                            \
    DUAL_ONE(k, c)
#define DUAL_ONE(k, c)                                                         \
    trt += c * v.wave[4 * k + 2];                                              \
    last += c * v.wave[4 * k + 3].xy
#define DUAL_NEAR(p)                                                           \
    vec4(tt.x * v.near[p].xyz + tt.y * v.near[8 + p].xyz +                     \
             tt.z * v.near[16 + p].xyz + tt.w * v.near[24 + p].xyz,            \
         r.x * v.near[p].w + r.y * v.near[8 + p].w + r.z * v.near[16 + p].w)
#define DUAL_FAR(p)                                                            \
    (trt.x * v.far[p] + trt.y * v.far[9 + p] + trt.z * v.far[18 + p] +         \
     trt.w * v.far[27 + p] + last.x * v.far[36 + p] + last.y * v.far[45 + p])

#ifdef GUARDS
DualSeries dual_mean; // over Phi
#endif

DualSeries dual_series(DualView v, float cos_phi)
{
    // cos(n Phi), n = 1, 3, 5, ... 21
    float twice = 4.0 * cos_phi * cos_phi - 2.0;
    float c1 = cos_phi, c3 = twice * c1 - c1, c5 = twice * c3 - c1;
    float c7 = twice * c5 - c3, c9 = twice * c7 - c5, c11 = twice * c9 - c7;
    float c13 = twice * c11 - c9, c15 = twice * c13 - c11;
    float c17 = twice * c15 - c13, c19 = twice * c17 - c15;
    vec4 tt = v.wave[0], trt = v.wave[2];
    vec3 r = v.wave[1].xyz;
    vec2 last = v.wave[3].xy;
#ifdef GUARDS
    dual_mean = DualSeries(DUAL_NEAR(0), DUAL_NEAR(1), DUAL_NEAR(2),
                           DUAL_NEAR(3), DUAL_NEAR(4), DUAL_NEAR(5),
                           DUAL_NEAR(6), DUAL_NEAR(7), DUAL_FAR(0), DUAL_FAR(1),
                           DUAL_FAR(2), DUAL_FAR(3), DUAL_FAR(4), DUAL_FAR(5),
                           DUAL_FAR(6), DUAL_FAR(7), DUAL_FAR(8));
#endif
    DUAL_BOTH(1, c1);
    DUAL_BOTH(2, c3);
    DUAL_BOTH(3, c5);
    DUAL_BOTH(4, c7);
    DUAL_BOTH(5, c9);
    DUAL_BOTH(6, c11);
    DUAL_BOTH(7, c13);
    DUAL_ONE(8, c15);
    DUAL_ONE(9, c17);
    DUAL_ONE(10, c19);
    DUAL_ONE(11, (twice * c19 - c17));
    return DualSeries(DUAL_NEAR(0), DUAL_NEAR(1), DUAL_NEAR(2), DUAL_NEAR(3),
                      DUAL_NEAR(4), DUAL_NEAR(5), DUAL_NEAR(6), DUAL_NEAR(7),
                      DUAL_FAR(0), DUAL_FAR(1), DUAL_FAR(2), DUAL_FAR(3),
                      DUAL_FAR(4), DUAL_FAR(5), DUAL_FAR(6), DUAL_FAR(7),
                      DUAL_FAR(8));
}

struct DualPlace { // what one theta_i says
    float cos_i, cos_d;
    float x; // 2 eta/eta' - 1
};

DualPlace dual_place(float theta_i, float theta_o)
{
    DualPlace p;
    p.cos_i = special_cos(theta_i);
    GUARD_LIVE(p.cos_i > 0.0);
    GUARD(GUARD_DUAL_COS_D, special_cos(0.5 * (theta_o - theta_i)) < 1e-4);
    p.cos_d = max(special_cos(0.5 * (theta_o - theta_i)), 1e-4);
    p.x = dual_index.y * p.cos_d *
              inversesqrt(dual_index.x + p.cos_d * p.cos_d) -
          1.0;
    return p;
}

// The polynomials of x for R, TT and TRT.
float dual_sum_at_r(DualSeries s, float x)
{
    float n = s.n6.w + x * s.n7.w;
    n = s.n3.w + x * (s.n4.w + x * (s.n5.w + x * n));
    return s.n0.w + x * (s.n1.w + x * (s.n2.w + x * n));
}

vec3 dual_sum_at_tt(DualSeries s, float x)
{
    vec3 n = s.n6.xyz + x * s.n7.xyz;
    n = s.n3.xyz + x * (s.n4.xyz + x * (s.n5.xyz + x * n));
    return s.n0.xyz + x * (s.n1.xyz + x * (s.n2.xyz + x * n));
}

vec3 dual_sum_at_trt(DualSeries s, float x)
{
    vec3 n = s.f6 + x * (s.f7 + x * s.f8);
    n = s.f3 + x * (s.f4 + x * (s.f5 + x * n));
    return s.f0 + x * (s.f1 + x * (s.f2 + x * n));
}

// cos theta_i / cos^2 theta_d N^G.
float dual_at_r(DualSeries s, DualPlace p)
{
    float n = dual_sum_at_r(s, p.x);
    GUARD(GUARD_DUAL_R, n < -0.01 * dual_sum_at_r(dual_mean, p.x));
    return max(n, 0.0) * p.cos_i / (p.cos_d * p.cos_d);
}

vec3 dual_at_tt(DualSeries s, DualPlace p)
{
    vec3 n = dual_sum_at_tt(s, p.x);
    GUARD(GUARD_DUAL_TT, lessThan(n, -0.01 * dual_sum_at_tt(dual_mean, p.x)));
    return max(n, 0.0) * p.cos_i;
}

vec3 dual_at_trt(DualSeries s, DualPlace p)
{
    float u = 1.0 - 0.65 * p.cos_d;
    vec3 n = dual_sum_at_trt(s, p.x);
    float schlick = dual_index.z + (1.0 - dual_index.z) * xu_fifth(u);
    GUARD(GUARD_DUAL_TRT, lessThan(n, -0.01 * dual_sum_at_trt(dual_mean, p.x)));
    return max(n, 0.0) * (p.cos_i * schlick);
}

// --- the integral over theta_i (eq 27) --------------------------------------
// psi_f times M_t is a Gaussian, cut off at +-pi/2.  Five Gauss-Legendre nodes
// over +-1.985 widths, or as much of that as lies inside: there their sum of
// exp(-t^2) is sqrt(pi), so that nothing needs to be made up for.  The channels
// have their own sigma_f, but share the nodes of the mean one: their masses are
// exact, their shift and width against it corrected to second order (t, t^2).
struct DualRule {
    vec4 at, t, weight;      // theta_i; in widths from the centre
    float at4, t4, weight4;  // the middle node
    vec3 mass, tilt, widen;  // a channel's
};

DualRule dual_rule(float centre, float width, float theta_j, vec3 sigma2)
{
    DualRule r;
    float w2 = width * width, apart = centre - theta_j;
    float s2 = dot(sigma2, vec3(1.0 / 3.0));
    float both = 1.0 / (w2 + s2), share = s2 * both;
    float l = width * sqrt(share), mu = theta_j + apart * share;
    float per = 1.0 / l, from = (-XU_HALF_PI - mu) * per, to = from + XU_PI * per;
    float lo = max(from, min(-1.985, to - 1.0));
    float hi = min(to, max(1.985, from + 1.0)), h = 0.5 * (hi - lo);
    const vec4 x = vec4(-0.906179846, -0.538469310, 0.538469310, 0.906179846);
    const vec4 w = 0.564189584 *
                   vec4(0.236926885, 0.478628670, 0.478628670, 0.236926885);
    r.t4 = 0.5 * (lo + hi);
    r.t = r.t4 + h * x;
    r.at4 = mu + l * r.t4;
    r.at = mu + l * r.t;
    r.weight4 = (0.564189584 * 0.568888889) * h * exp(-r.t4 * r.t4);
    r.weight = h * w * exp(-r.t * r.t);
    // Channel by channel.
    vec3 root = inversesqrt(w2 + sigma2), own = root * root;
    r.mass = 0.564189584 * root * exp(-apart * apart * own);
    vec3 change = sigma2 * own - share;
    GUARD_LIVE(any(greaterThan(exp(-apart * apart * own), vec3(1e-3))));
    GUARD(GUARD_DUAL_TILT, greaterThan(abs(2.0 * apart * per * change), vec3(1.0)));
    GUARD(GUARD_DUAL_WIDEN, greaterThan(change / share, vec3(1.0)));
    r.tilt = clamp(2.0 * apart * per * change, -1.0, 1.0);
    r.widen = min(change / share, 1.0) + 0.5 * r.tilt * r.tilt;
    return r;
}

// Mass and corrections of a channel with node sums of f, t f, (t^2 - 1/2) f.
vec3 dual_finish(DualRule r, vec3 f0, vec3 f1, vec3 f2)
{
    GUARD(GUARD_DUAL_FINISH,
          lessThan(f0 + r.tilt * f1 + r.widen * f2, vec3(0.0)));
    return r.mass * max(f0 + r.tilt * f1 + r.widen * f2, 0.0);
}

vec3 dual_sum_r(DualSeries s, DualRule r, float theta_o)
{
    float mid = r.weight4 * dual_at_r(s, dual_place(r.at4, theta_o));
    vec4 f = r.weight * vec4(dual_at_r(s, dual_place(r.at.x, theta_o)),
                             dual_at_r(s, dual_place(r.at.y, theta_o)),
                             dual_at_r(s, dual_place(r.at.z, theta_o)),
                             dual_at_r(s, dual_place(r.at.w, theta_o)));
    return dual_finish(r, vec3(dot(f, vec4(1.0)) + mid),
                       vec3(dot(f, r.t) + r.t4 * mid),
                       vec3(dot(f, r.t * r.t - 0.5) +
                            (r.t4 * r.t4 - 0.5) * mid));
}

vec3 dual_sum_five(DualRule r, vec3 a, vec3 b, vec3 mid, vec3 c, vec3 d)
{
    vec4 square = r.t * r.t - 0.5;
    a *= r.weight.x;
    b *= r.weight.y;
    c *= r.weight.z;
    d *= r.weight.w;
    mid *= r.weight4;
    return dual_finish(r, a + b + mid + c + d,
                       r.t.x * a + r.t.y * b + r.t4 * mid + r.t.z * c +
                           r.t.w * d,
                       square.x * a + square.y * b +
                           (r.t4 * r.t4 - 0.5) * mid + square.z * c +
                           square.w * d);
}

vec3 dual_sum_tt(DualSeries s, DualRule r, float theta_o)
{
    return dual_sum_five(r, dual_at_tt(s, dual_place(r.at.x, theta_o)),
                         dual_at_tt(s, dual_place(r.at.y, theta_o)),
                         dual_at_tt(s, dual_place(r.at4, theta_o)),
                         dual_at_tt(s, dual_place(r.at.z, theta_o)),
                         dual_at_tt(s, dual_place(r.at.w, theta_o)));
}

vec3 dual_sum_trt(DualSeries s, DualRule r, float theta_o)
{
    return dual_sum_five(r, dual_at_trt(s, dual_place(r.at.x, theta_o)),
                         dual_at_trt(s, dual_place(r.at.y, theta_o)),
                         dual_at_trt(s, dual_place(r.at4, theta_o)),
                         dual_at_trt(s, dual_place(r.at.z, theta_o)),
                         dual_at_trt(s, dual_place(r.at.w, theta_o)));
}

// --- local scattering (eq 29) -----------------------------------------------
// Integral of S_back cos theta_i with a normalised Gaussian about theta_j of
// width^2 spread2, times lit: what S_back meets has more or less than that
// Gaussian, but where both have their peaks at most as much.
vec3 dual_back(DualView v, float theta_j, vec3 spread2, float lit)
{
    vec3 both = 1.0 / (v.width2 + spread2), r2 = v.width2 * both;
    vec3 away = theta_j - v.centre, z2 = 2.0 * away * away * both;
    vec3 z = 1.41421356 * away * sqrt(both), r3 = r2 * sqrt(r2);
    vec3 shape = 1.0 + v.skew * r3 * z * (z2 - 3.0) +
                 v.peak * r2 * r2 * ((z2 - 6.0) * z2 + 3.0);
    GUARD_LIVE(true);
    GUARD(GUARD_DUAL_BACK, lessThan(shape * exp(-0.5 * z2), vec3(-0.01)));
    vec3 meet = lit * exp(-0.5 * z2);
    GUARD(GUARD_DUAL_PEAK, greaterThan(meet, vec3(1.0)));
    return max(v.mass * shape, 0.0) * (0.564189584 * sqrt(both) * min(meet, 1.0));
}

vec3 dual_back(DualView v, float theta_j, vec3 spread2)
{
    return dual_back(v, theta_j, spread2, 1.0);
}

// The light's own lobe: cos theta_i and what the circular Gaussian has more than
// the plain one, at three nodes of the product; its half circle at the centre.
vec3 dual_back_direct(DualView v, Srbf l, float cos_phi)
{
    const vec3 offset = vec3(-1.22474487, 0.0, 1.22474487);
    float l2 = l.lambda * l.lambda, w2 = dot(v.width2, vec3(1.0 / 3.0));
    float share = l2 / (l2 + w2);
    float mu = dot(v.centre, vec3(1.0 / 3.0)) - l.theta;
    GUARD(GUARD_DUAL_CENTRE, abs(l.theta + mu * share) > XU_HALF_PI);
    mu = clamp(l.theta + mu * share, -XU_HALF_PI, XU_HALF_PI);
    vec3 x = mu - l.theta + sqrt(w2 * share) * offset, x2 = x * x;
    // x^2 - 4 sin^2(x/2)
    GUARD(GUARD_DUAL_MORE,
          greaterThan(x2 * x2 * (1.0 / 12.0 - x2 * (1.0 / 360.0)) / l2,
                      vec3(60.0)));
    vec3 more = exp(min(x2 * x2 * (1.0 / 12.0 - x2 * (1.0 / 360.0)) / l2, 60.0));
    float cos_i = special_cos(mu), kappa = 2.0 * cos_i * special_cos(l.theta) / l2;
    vec3 fall = vec3(special_cos(l.theta + x.x), cos_i, special_cos(l.theta + x.z));
    // I0e of another theta_i goes with the root of its cosine, or with nothing
    float lit = dot(fall * more, vec3(1.0, 4.0, 1.0) / 6.0);
    float i0e = special_i0e(kappa);
    // the channels' own centres may lie elsewhere than the mean one
    return dual_back(v, l.theta, vec3(l2), lit) *
           (3.5449077 * l.lambda * i0e * dual_half_share(kappa, i0e, cos_phi));
}

// sigma_f: Xu width of psi_f for each channel; mask: which of R, TT, TRT are
// shown in MG.
void dual_modes(Fibre f, DualView v, Srbf l, float phi_o, vec3 sigma_f,
                vec3 mask, out vec3 MG, out vec3 ML, out vec3 MLd)
{
    float cos_phi = cos(phi_o - l.phi);
    vec3 sigma2 = sigma_f * sigma_f, width = 2.82842712 * f.beta;
    vec3 centre = 2.0 * f.alpha - v.theta_o;
    DualSeries s = dual_series(v, cos_phi);
    MG = mask.x * dual_sum_r(s, dual_rule(centre.x, width.x, l.theta, sigma2),
                             v.theta_o);
#ifndef XU_NO_TT_TRT
    MG += mask.y * dual_sum_tt(s, dual_rule(centre.y, width.y, l.theta, sigma2),
                               v.theta_o);
    MG += mask.z *
          dual_sum_trt(s, dual_rule(centre.z, width.z, l.theta, sigma2),
                       v.theta_o);
#endif
    ML = dual_back(v, l.theta, sigma2) *
         ((1.0 - xu_across(phi_o - l.phi)) * (1.0 / XU_PI)); // eq 30
    MLd = dual_back_direct(v, l, cos_phi);
}

// N^G_R, N^G_TT, N^G_TRT of the first channel.
vec3 dual_half(Fibre f, float theta_d, float phi)
{
    DualSeries s = dual_series(dual_view(0.0), cos(phi));
    DualPlace p = dual_place(0.0, 2.0 * theta_d); // cos theta_i = 1
    return vec3(dual_at_r(s, p), dual_at_tt(s, p).x, dual_at_trt(s, p).x) *
           (p.cos_d * p.cos_d);
}
#endif

void dual_modes(Fibre f, Srbf l, float theta_o, float phi_o, vec3 sigma_f,
                vec3 mask, out vec3 MG, out vec3 ML, out vec3 MLd)
{
    dual_modes(f, dual_view(theta_o), l, phi_o, sigma_f, mask, MG, ML, MLd);
}
