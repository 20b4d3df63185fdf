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

const float DUAL_SHORT = 0.0259201; // what four nodes over +-1.8 miss

layout(std140, binding = 6) uniform Dual {
    vec4 dual_index;    // eta^2 - 1, 2 eta, F_0
    vec4 dual_near[56]; // [8 harmonics][7 powers]: TT red, green, blue; R
    vec4 dual_far[80];  // [10][8]: TRT red, green, blue
};

// --- a view -----------------------------------------------------------------
// What does not change from light to light: S_back cos theta_i as it is seen from
// one theta_o, without its azimuth, which in theta_i is a Gaussian with two
// Hermite terms; and the block above, since a value of it costs more than a
// multiplication inside the loop over lights.
struct DualView {
    float theta_o;
    vec3 mass, centre, width2, skew, peak;
    vec4 near[56];
    vec3 far[80];
};

#define DUAL_LOAD_8(to, from, i, part)                                         \
    to[i] = from[i] part;                                                      \
    to[i + 1] = from[i + 1] part;                                              \
    to[i + 2] = from[i + 2] part;                                              \
    to[i + 3] = from[i + 3] part;                                              \
    to[i + 4] = from[i + 4] part;                                              \
    to[i + 5] = from[i + 5] part;                                              \
    to[i + 6] = from[i + 6] part;                                              \
    to[i + 7] = from[i + 7] part

DualView dual_view(float theta_o)
{
    DualView v;
    v.theta_o = theta_o;
    v.mass = dual_layer(theta_o, 2);
    v.centre = dual_layer(theta_o, 3);
    v.width2 = dual_layer(theta_o, 4);
    v.skew = dual_layer(theta_o, 5);
    v.peak = dual_layer(theta_o, 6);
    DUAL_LOAD_8(v.near, dual_near, 0, );
    DUAL_LOAD_8(v.near, dual_near, 8, );
    DUAL_LOAD_8(v.near, dual_near, 16, );
    DUAL_LOAD_8(v.near, dual_near, 24, );
    DUAL_LOAD_8(v.near, dual_near, 32, );
    DUAL_LOAD_8(v.near, dual_near, 40, );
    DUAL_LOAD_8(v.near, dual_near, 48, );
    DUAL_LOAD_8(v.far, dual_far, 0, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 8, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 16, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 24, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 32, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 40, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 48, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 56, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 64, .rgb);
    DUAL_LOAD_8(v.far, dual_far, 72, .rgb);
    return v;
}

// --- N^G (eq 28) ------------------------------------------------------------
// The series of dual_azimuth.h summed over the harmonics of one Phi: what is
// left is a polynomial of theta_d.
struct DualSeries {
    vec4 n0, n1, n2, n3, n4, n5, n6;     // TT red, green, blue; R
    vec3 f0, f1, f2, f3, f4, f5, f6, f7; // TRT
};

#define DUAL_NEAR(p)                                                           \
    (v.near[p] + c.x * v.near[7 + p] + c.y * v.near[14 + p] +                  \
     c.z * v.near[21 + p] + c.w * v.near[28 + p] + d.x * v.near[35 + p] +      \
     d.y * v.near[42 + p] + d.z * v.near[49 + p])
#define DUAL_FAR(p)                                                            \
    (v.far[p] + c.x * v.far[8 + p] + c.y * v.far[16 + p] +                     \
     c.z * v.far[24 + p] + c.w * v.far[32 + p] + d.x * v.far[40 + p] +         \
     d.y * v.far[48 + p] + d.z * v.far[56 + p] + d.w * v.far[64 + p] +         \
     e * v.far[72 + p])

DualSeries dual_series(DualView v, float cos_phi)
{
    // cos(n Phi), n = 1, 3, 5, ...
    float twice = 4.0 * cos_phi * cos_phi - 2.0, e;
    vec4 c, d;
    c.x = cos_phi;
    c.y = twice * c.x - c.x;
    c.z = twice * c.y - c.x;
    c.w = twice * c.z - c.y;
    d.x = twice * c.w - c.z;
    d.y = twice * d.x - c.w;
    d.z = twice * d.y - d.x;
    d.w = twice * d.z - d.y;
    e = twice * d.w - d.z;
    return DualSeries(
        DUAL_NEAR(0), DUAL_NEAR(1), DUAL_NEAR(2), DUAL_NEAR(3), DUAL_NEAR(4),
        DUAL_NEAR(5), DUAL_NEAR(6), DUAL_FAR(0), DUAL_FAR(1), DUAL_FAR(2),
        DUAL_FAR(3), DUAL_FAR(4), DUAL_FAR(5), DUAL_FAR(6), DUAL_FAR(7));
}

struct DualPlace { // what one theta_i says
    float cos_i, cos_d;
    float x; // 2 eta/eta' - 1
};

DualPlace dual_place(float theta_i, float theta_o)
{
    DualPlace p;
    p.cos_i = special_cos(theta_i);
    p.cos_d = max(special_cos(0.5 * (theta_o - theta_i)), 1e-4);
    p.x = dual_index.y * p.cos_d *
              inversesqrt(dual_index.x + p.cos_d * p.cos_d) -
          1.0;
    return p;
}

// cos theta_i / cos^2 theta_d N^G.
float dual_at_r(DualSeries s, DualPlace p)
{
    float x = p.x, n = s.n5.w + x * s.n6.w;
    n = s.n0.w + x * (s.n1.w + x * (s.n2.w + x * (s.n3.w + x * (s.n4.w + x * n))));
    return max(n, 0.0) * p.cos_i / (p.cos_d * p.cos_d);
}

vec3 dual_at_tt(DualSeries s, DualPlace p)
{
    float x = p.x;
    vec3 n = s.n5.xyz + x * s.n6.xyz;
    n = s.n2.xyz + x * (s.n3.xyz + x * (s.n4.xyz + x * n));
    n = s.n0.xyz + x * (s.n1.xyz + x * n);
    return max(n, 0.0) * p.cos_i;
}

vec3 dual_at_trt(DualSeries s, DualPlace p)
{
    float x = p.x, u = 1.0 - 0.65 * p.cos_d;
    vec3 n = s.f5 + x * (s.f6 + x * s.f7);
    n = s.f2 + x * (s.f3 + x * (s.f4 + x * n));
    n = s.f0 + x * (s.f1 + x * n);
    float schlick = dual_index.z + (1.0 - dual_index.z) * xu_fifth(u);
    return max(n, 0.0) * (p.cos_i * schlick);
}

// --- the integral over theta_i (eq 27) --------------------------------------
// psi_f times M_t is a Gaussian, cut off at +-pi/2.  Four Gauss-Legendre nodes
// over +-1.8 widths or as much of it as lies inside; their sum of exp(-t^2) is
// then right in its second moment too, and short by 2.6 % over the whole width,
// by h^8 of that over less.  The channels have their own sigma_f, but share the
// nodes of the mean one: their masses are exact, their shift and width against
// it corrected to second order (t, t^2).
struct DualRule {
    vec4 at, t, weight;     // theta_i; in widths from the centre
    vec3 mass, tilt, widen; // a channel's
};

DualRule dual_rule(float centre, float width, float theta_j, vec3 sigma2)
{
    DualRule r;
    float w2 = width * width, apart = centre - theta_j;
    float s2 = dot(sigma2, vec3(1.0 / 3.0));
    float both = 1.0 / (w2 + s2), share = s2 * both;
    float l = width * sqrt(share), mu = theta_j + apart * share;
    float per = 1.0 / l, from = (-XU_HALF_PI - mu) * per, to = from + XU_PI * per;
    float lo = max(from, min(-1.8, to - 1.0)), hi = min(to, max(1.8, from + 1.0));
    float h = 0.5 * (hi - lo), h2 = h * h * (1.0 / 3.24), h4 = h2 * h2;
    const vec4 x = vec4(-0.861136312, -0.339981044, 0.339981044, 0.861136312);
    const vec4 w = 0.564189584 *
                   vec4(0.347854845, 0.652145155, 0.652145155, 0.347854845);
    r.t = 0.5 * (lo + hi) + h * x;
    r.at = mu + l * r.t;
    r.weight = h * (1.0 + DUAL_SHORT * h4 * h4) * w * exp(-r.t * r.t);
    // Channel by channel.
    vec3 root = inversesqrt(w2 + sigma2), own = root * root;
    r.mass = 0.564189584 * root * exp(-apart * apart * own);
    vec3 change = sigma2 * own - share;
    r.tilt = clamp(2.0 * apart * per * change, -1.0, 1.0);
    r.widen = min(change / share, 1.0) + 0.5 * r.tilt * r.tilt;
    return r;
}

// Mass and corrections of a channel with node sums of f, t f, (t^2 - 1/2) f.
vec3 dual_finish(DualRule r, vec3 f0, vec3 f1, vec3 f2)
{
    return r.mass * max(f0 + r.tilt * f1 + r.widen * f2, 0.0);
}

vec3 dual_sum_r(DualSeries s, DualRule r, float theta_o)
{
    vec4 f = r.weight * vec4(dual_at_r(s, dual_place(r.at.x, theta_o)),
                             dual_at_r(s, dual_place(r.at.y, theta_o)),
                             dual_at_r(s, dual_place(r.at.z, theta_o)),
                             dual_at_r(s, dual_place(r.at.w, theta_o)));
    return dual_finish(r, vec3(dot(f, vec4(1.0))), vec3(dot(f, r.t)),
                       vec3(dot(f, r.t * r.t - 0.5)));
}

vec3 dual_sum_four(DualRule r, vec3 a, vec3 b, vec3 c, vec3 d)
{
    a *= r.weight.x;
    b *= r.weight.y;
    c *= r.weight.z;
    d *= r.weight.w;
    vec4 square = r.t * r.t - 0.5;
    return dual_finish(r, a + b + c + d,
                       r.t.x * a + r.t.y * b + r.t.z * c + r.t.w * d,
                       square.x * a + square.y * b + square.z * c +
                           square.w * d);
}

vec3 dual_sum_tt(DualSeries s, DualRule r, float theta_o)
{
    return dual_sum_four(r, dual_at_tt(s, dual_place(r.at.x, theta_o)),
                         dual_at_tt(s, dual_place(r.at.y, theta_o)),
                         dual_at_tt(s, dual_place(r.at.z, theta_o)),
                         dual_at_tt(s, dual_place(r.at.w, theta_o)));
}

vec3 dual_sum_trt(DualSeries s, DualRule r, float theta_o)
{
    return dual_sum_four(r, dual_at_trt(s, dual_place(r.at.x, theta_o)),
                         dual_at_trt(s, dual_place(r.at.y, theta_o)),
                         dual_at_trt(s, dual_place(r.at.z, theta_o)),
                         dual_at_trt(s, dual_place(r.at.w, theta_o)));
}

// --- local scattering (eq 29) -----------------------------------------------
// Integral of S_back cos theta_i with a normalised Gaussian about theta_j of
// width^2 spread2.
vec3 dual_back(DualView v, float theta_j, vec3 spread2)
{
    vec3 both = 1.0 / (v.width2 + spread2), r2 = v.width2 * both;
    vec3 away = theta_j - v.centre, z2 = 2.0 * away * away * both;
    vec3 z = 1.41421356 * away * sqrt(both), r3 = r2 * sqrt(r2);
    vec3 shape = 1.0 + v.skew * r3 * z * (z2 - 3.0) +
                 v.peak * r2 * r2 * ((z2 - 6.0) * z2 + 3.0);
    return max(v.mass * shape, 0.0) * (0.564189584 * sqrt(both) * exp(-0.5 * z2));
}

// The light's own lobe: cos theta_i and what the circular Gaussian has more than
// the plain one, at three nodes of the product; its half circle at the centre.
vec3 dual_back_direct(DualView v, Srbf l, float cos_phi)
{
    const vec3 offset = vec3(-1.22474487, 0.0, 1.22474487);
    float l2 = l.lambda * l.lambda, w2 = dot(v.width2, vec3(1.0 / 3.0));
    float share = l2 / (l2 + w2);
    float mu = dot(v.centre, vec3(1.0 / 3.0)) - l.theta;
    mu = clamp(l.theta + mu * share, -XU_HALF_PI, XU_HALF_PI);
    vec3 x = mu - l.theta + sqrt(w2 * share) * offset, x2 = x * x;
    // x^2 - 4 sin^2(x/2)
    vec3 more = exp(min(x2 * x2 * (1.0 / 12.0 - x2 * (1.0 / 360.0)) / l2, 60.0));
    float cos_i = special_cos(mu), kappa = 2.0 * cos_i * special_cos(l.theta) / l2;
    vec3 fall = vec3(special_cos(l.theta + x.x), cos_i, special_cos(l.theta + x.z));
    // I0e of another theta_i goes with the root of its cosine, or with nothing
    float lit = dot(fall * more, vec3(1.0, 4.0, 1.0) / 6.0);
    float i0e = special_i0e(kappa);
    return dual_back(v, l.theta, vec3(l2)) *
           (3.5449077 * l.lambda * lit * i0e *
            dual_half_share(kappa, i0e, cos_phi));
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
