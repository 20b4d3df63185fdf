// xu.glsl - single scattering of one SRBF light by one fibre: Xu 2011, eq 11,
// with M_t normalised over theta_i and L_j, diameter and transmittance 1.
//
// Variants:
//   XU_M=m         segments of the outer integral; without it the uniform xu_m
//   XU_FINE_NODES  nodes that converge as m grows, else the printed ones
//   XU_ECCENTRIC   a != 1; without it no code for an index that varies
//   XU_NO_TT_TRT   opaque fibre: only R
// Finite and >= 0 for every legal parameter and |theta| <= pi/2.
#include "xu_azimuth.glsl"

struct Srbf { // in the fibre's frame; lambda is a Xu width
    float theta;
    float phi;
    float lambda;
};

#ifdef XU_M
const int xu_m = XU_M;
#else
layout(location = 16) uniform int xu_m;
#endif

const float XU_HALF_PI = 1.57079633;

// The product of light and M_t along theta_i: mass * Gaussian, t = (theta_i -
// mu) / width (eq 7 without its factor 2, eq 11).  One component a mode.
struct XuLong {
    vec3 mu, width, mass; // mass: what multiplies Int exp(-t^2) f dt
    vec3 lo, hi;          // t at theta_i = -+pi/2
};

XuLong xu_long(Fibre f, Srbf l, float theta_o)
{
    XuLong g;
    vec3 width = 2.82842712 * f.beta, mu = 2.0 * f.alpha - theta_o;
    vec3 w2 = width * width, apart = mu - l.theta;
    float l2 = l.lambda * l.lambda;
    vec3 r = inversesqrt(w2 + l2), r2 = r * r;
    g.mu = l.theta + apart * (l2 * r2);
    g.width = width * l.lambda * r;
    g.mass = 0.564189584 * l.lambda * r * exp(-apart * apart * r2);
    g.lo = (-XU_HALF_PI - g.mu) / g.width;
    g.hi = (XU_HALF_PI - g.mu) / g.width;
    return g;
}

// |x| brought to [0, pi], in units of pi.
float xu_across(float x)
{
    float turns = x * (0.5 / XU_PI);
    return 2.0 * abs(turns - round(turns));
}

XuLight xu_light(Srbf l, float phi_o)
{
    XuLight x;
    float phi = phi_o - l.phi;
    GUARD(GUARD_COS_J, cos(l.theta) < 0.0);
    x.kappa = 2.0 * max(cos(l.theta), 0.0) / (l.lambda * l.lambda);
    x.cos_half = cos(0.5 * phi);
    x.sin_half = sin(0.5 * phi);
    x.across = xu_across(phi);
    x.turn_across = xu_across(phi_o + l.phi);
    return x;
}

XuPlace xu_place(float theta_i, float theta_o, XuLight l)
{
    float theta_d = 0.5 * (theta_o - theta_i), ci = special_cos(theta_i);
    XuPlace p;
    GUARD_LIVE(abs(theta_i) < XU_HALF_PI); // else nothing comes of it
    GUARD(GUARD_COS_D, special_cos(theta_d) < 1e-6);
    p.cos_d = max(special_cos(theta_d), 1e-6);
    p.theta = abs(theta_d) * (1.0 / XU_HALF_PI);
    p.fall = ci / p.cos_d;
    GUARD(GUARD_FALL, p.fall * p.fall > 4.0);
    p.fall = min(p.fall * p.fall, 4.0);
    p.kappa = l.kappa * ci;
    return p;
}

// The three integrands at their three nodes: cos^2 theta_i / cos^2 theta_d N_t.
float xu_at_r(Fibre f, XuLight l, XuPlace p)
{
    float f0 = (f.eta - 1.0) / (f.eta + 1.0);
    return p.fall * xu_n_r(f0 * f0, l, p);
}

vec3 xu_at_tt(Fibre f, XuLight l, XuPlace p)
{
    XuPath path = xu_path(f.eta - 1.0, f.sigma_a, p.cos_d);
    XuTt n = xu_tt_lobe(path, xu_eta_column(f.eta), p.theta);
    return p.fall * xu_n_tt(n, l, p.kappa);
}

vec3 xu_at_trt(Fibre f, XuLight l, XuPlace p)
{
    float eta_1 = f.eta - 1.0;
#ifdef XU_ECCENTRIC
    eta_1 = xu_eta_star_1(f, l, p.kappa);
#endif
    XuPath path = xu_path(eta_1, f.sigma_a, p.cos_d);
    XuTrt n = xu_trt_lobe(f, path, xu_eta_column(eta_1 + 1.0), p.theta);
    return p.fall * xu_n_trt(n, l, p.kappa);
}

#include "xu_nodes.glsl"

#ifdef XU_NODES_FOUR
// Written out: a loop of three turns costs a CPU renderer a third more.
float xu_sum_r(Fibre f, XuLight l, XuLong g, float theta_o)
{
    vec3 w = g.mass.x * xu_weights(g.lo.x, g.hi.x);
    float mu = g.mu.x, d = g.width.x;
    return w.x * xu_at_r(f, l, xu_place(mu - d, theta_o, l)) +
           w.y * xu_at_r(f, l, xu_place(mu, theta_o, l)) +
           w.z * xu_at_r(f, l, xu_place(mu + d, theta_o, l));
}

vec3 xu_sum_tt(Fibre f, XuLight l, XuLong g, float theta_o)
{
    vec3 w = g.mass.y * xu_weights(g.lo.y, g.hi.y);
    float mu = g.mu.y, d = g.width.y;
    return w.x * xu_at_tt(f, l, xu_place(mu - d, theta_o, l)) +
           w.y * xu_at_tt(f, l, xu_place(mu, theta_o, l)) +
           w.z * xu_at_tt(f, l, xu_place(mu + d, theta_o, l));
}

vec3 xu_sum_trt(Fibre f, XuLight l, XuLong g, float theta_o)
{
    vec3 w = g.mass.z * xu_weights(g.lo.z, g.hi.z);
    float mu = g.mu.z, d = g.width.z;
    return w.x * xu_at_trt(f, l, xu_place(mu - d, theta_o, l)) +
           w.y * xu_at_trt(f, l, xu_place(mu, theta_o, l)) +
           w.z * xu_at_trt(f, l, xu_place(mu + d, theta_o, l));
}

void xu_sum(Fibre f, XuLight l, XuLong g, float theta_o, out vec3 R,
            out vec3 TT, out vec3 TRT)
{
    R = vec3(xu_sum_r(f, l, g, theta_o));
    TT = TRT = vec3(0.0);
#ifndef XU_NO_TT_TRT
    TT = xu_sum_tt(f, l, g, theta_o);
    TRT = xu_sum_trt(f, l, g, theta_o);
#endif
}
#else
void xu_add_node(Fibre f, XuLight l, XuLong g, float theta_o, int s,
                 inout XuNodes n, inout vec3 R, inout vec3 TT, inout vec3 TRT)
{
    vec3 t, weight;
    xu_nodes_next(n, g, s, t, weight);
    vec3 at = g.mu + t * g.width;
    weight *= g.mass;
    R += weight.x * xu_at_r(f, l, xu_place(at.x, theta_o, l));
#ifndef XU_NO_TT_TRT
    TT += weight.y * xu_at_tt(f, l, xu_place(at.y, theta_o, l));
    TRT += weight.z * xu_at_trt(f, l, xu_place(at.z, theta_o, l));
#endif
}

void xu_sum(Fibre f, XuLight l, XuLong g, float theta_o, out vec3 R,
            out vec3 TT, out vec3 TRT)
{
    R = TT = TRT = vec3(0.0);
    XuNodes n = xu_nodes_begin(g);
#ifdef XU_NODES_FEW // written out, as above
    xu_add_node(f, l, g, theta_o, 0, n, R, TT, TRT);
#if XU_M > 2
    xu_add_node(f, l, g, theta_o, 1, n, R, TT, TRT);
#endif
#if XU_M > 3
    xu_add_node(f, l, g, theta_o, 2, n, R, TT, TRT);
#endif
#if XU_M > 4
    xu_add_node(f, l, g, theta_o, 3, n, R, TT, TRT);
#endif
#if XU_M > 5
    xu_add_node(f, l, g, theta_o, 4, n, R, TT, TRT);
#endif
#else
    for (int s = 0; s < xu_m - 1; s++)
        xu_add_node(f, l, g, theta_o, s, n, R, TT, TRT);
#endif
}
#endif

// M_t(omega_j, lambda_j) of eq 11 for each colour channel.
void xu_modes(Fibre f, Srbf l, float theta_o, float phi_o, out vec3 R,
              out vec3 TT, out vec3 TRT)
{
    xu_sum(f, xu_light(l, phi_o), xu_long(f, l, theta_o), theta_o, R, TT, TRT);
}
