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
    x.kappa = 2.0 * max(cos(l.theta), 0.0) / (l.lambda * l.lambda);
    x.cos_half = cos(0.5 * phi);
    x.sin_half = sin(0.5 * phi);
    x.across = xu_across(phi);
    x.turn_across = xu_across(phi_o + l.phi);
    return x;
}

XuPlace xu_place(float theta_i, float theta_o, XuLight l)
{
    theta_i = clamp(theta_i, -XU_HALF_PI, XU_HALF_PI);
    float theta_d = 0.5 * (theta_o - theta_i);
    float ci = max(cos(theta_i), 0.0), cd = max(cos(theta_d), 1e-6);
    XuPlace p;
    p.cos_d = cd;
    p.theta = abs(theta_d) * (1.0 / XU_HALF_PI);
    p.fall = min(ci * ci / (cd * cd), 4.0);
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

// One node of each mode: theta_i and weight, x = R, y = TT, z = TRT.
void xu_add_node(Fibre f, XuLight l, float theta_o, vec3 theta_i, vec3 weight,
                 inout vec3 R, inout vec3 TT, inout vec3 TRT)
{
    R += weight.x * xu_at_r(f, l, xu_place(theta_i.x, theta_o, l));
#ifndef XU_NO_TT_TRT
    TT += weight.y * xu_at_tt(f, l, xu_place(theta_i.y, theta_o, l));
    TRT += weight.z * xu_at_trt(f, l, xu_place(theta_i.z, theta_o, l));
#endif
}

// M_t(omega_j, lambda_j) of eq 11 for each colour channel.
void xu_modes(Fibre f, Srbf l, float theta_o, float phi_o, out vec3 R,
              out vec3 TT, out vec3 TRT)
{
    XuLong g = xu_long(f, l, theta_o);
    XuLight light = xu_light(l, phi_o);
    R = TT = TRT = vec3(0.0);
    XuNodes n = xu_nodes_begin(g);
    for (int s = 0; s < xu_m - 1; s++) {
        vec3 t, weight;
        xu_nodes_next(n, g, s, t, weight);
        xu_add_node(f, light, theta_o, g.mu + t * g.width, weight * g.mass, R,
                    TT, TRT);
    }
}
