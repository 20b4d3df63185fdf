// xu_azimuth.glsl - the inner integrals N_t of Xu 2011 (eq 12) at one
// inclination: as printed but for what docs/METHODS.md lists.
//
// Three steps, so that each can be put into a table of its own:
//   xu_path      what theta_d and the index make of the fibre
//   xu_tt_lobe, xu_trt_lobes   of that, the circular Gaussians of N_t
//   xu_n_r, xu_n_tt, xu_n_trt  these against a light
#include "special.glsl"

struct Fibre { // angles in radians; components: x = R, y = TT, z = TRT
    float eta;
    vec3 sigma_a; // RGB, per radius
    float a;      // eccentricity
    vec3 alpha;   // shift in theta_h
    vec3 beta;    // standard deviation in theta_h
    float w_c;    // Xu width
    float delta_eta;
};

// What they hold is said in renderer/xu_tables.h; any resolution.
layout(binding = 0) uniform sampler2D xu_table_cosine;
layout(binding = 1) uniform sampler2D xu_table_tt;
layout(binding = 2) uniform sampler2D xu_table_trt;

const float XU_PI = 3.14159265;

struct XuLight { // what a light's azimuth, width and inclination say
    float kappa; // kappa' = kappa cos(theta_i): 2 cos(theta_j) / lambda_j^2
    float cos_half, sin_half; // of Phi/2, Phi = phi_o - phi_j
    float across;             // |Phi| / pi, in [0, 1]
    float turn_across; // the same of phi_o + phi_j
};

struct XuPlace { // what one theta_i says
    float cos_d;  // theta_d, kept off zero
    float theta;  // |theta_d| in units of pi/2
    float fall;   // cos^2 theta_i / cos^2 theta_d, at most 4
    float kappa;  // 2 / lambda'^2
};

struct XuPath {
    float c;            // cos theta_d
    float eta1, eta2;   // eta' and its square
    float inverse_eta2; // 1 / eta'^2
    float square_1;     // eta^2 - 1
    float over1, over4; // eta'^2 - 1, 4 - eta'^2 without cancellation
    float f;            // Schlick's F at h = 0
    float enter;        // (1 - f)^2
    float f0;           // F at normal incidence
    vec3 s;             // sigma_a'; T = exp(-2 s) at h = 0
};

struct XuTt { // b exp(-dark) g^c(phi; pi, .)
    float b;
    vec3 dark, kappa;
};

// eta' < 2: b (g^c(phi; phi*, k.x) + g^c(phi; -phi*, k.y)) + b2 g^c(phi; 0, k.z)
// eta' >= 2: b g^c(phi; 0, k), one k for each colour channel
struct XuTrt {
    vec3 b, b2, kappa;
    float cos_half, sin_half; // of phi*/2
    bool three;
};

// Half-texel steps in, so that the ends of the range fall on texel centres.
vec2 xu_texel(vec2 at, vec2 size)
{
    return (at * (size - 1.0) + 0.5) / size;
}

// Columns run over the logarithm of eta in [1, 10].
float xu_eta_column(float eta)
{
    GUARD(GUARD_ETA_COLUMN, eta < 1.0 || eta > 10.0);
    return clamp(log2(eta) * 0.301029996, 0.0, 1.0);
}

// Columns run over the logarithm of lambda' in [1e-3, 10]; lambda'^2 = 2/kappa.
float xu_lambda_column(float kappa)
{
    GUARD(GUARD_LAMBDA_FINE, kappa > 2e6);
    float l2 = 0.5 - 0.5 * log2(max(kappa, 1e-12));
    return clamp((l2 + 9.96578428) * 0.0752574990, 0.0, 1.0);
}

// (C_2, C_4, C_6) / C_0
vec3 xu_cosine_even(float column, float across)
{
    vec2 size = vec2(textureSize(xu_table_cosine, 0)) * vec2(1.0, 0.5);
    vec2 at = xu_texel(vec2(column, across), size);
    return textureLod(xu_table_cosine, vec2(at.x, 0.5 + 0.5 * at.y), 0.0).rgb;
}

// (C_1, C_3, C_5) / C_0
vec3 xu_cosine_odd(float column, float across)
{
    vec2 size = vec2(textureSize(xu_table_cosine, 0)) * vec2(1.0, 0.5);
    vec2 at = xu_texel(vec2(column, across), size);
    return textureLod(xu_table_cosine, vec2(at.x, 0.5 * at.y), 0.0).rgb;
}

float xu_fifth(float x)
{
    float x2 = x * x;
    return x2 * x2 * x;
}

// eta - 1 instead of eta: it is what the small numbers come from.
XuPath xu_path(float eta_1, vec3 sigma_a, float c)
{
    XuPath p;
    p.c = c;
    p.square_1 = eta_1 * (eta_1 + 2.0);
    float over_c = 1.0 / c, over_root = inversesqrt(p.square_1 + c * c);
    p.over1 = p.square_1 * over_c * over_c;
    p.over4 = 3.0 - p.over1;
    p.eta2 = 1.0 + p.over1;
    p.eta1 = p.eta2 * c * over_root; // eta' cos theta_d is the root
    p.inverse_eta2 = c * c * over_root * over_root;
    p.f0 = eta_1 / (eta_1 + 2.0);
    p.f0 *= p.f0;
    p.f = p.f0 + (1.0 - p.f0) * xu_fifth(1.0 - c);
    p.enter = (1.0 - p.f) * (1.0 - p.f);
    p.s = sigma_a * ((eta_1 + 1.0) * over_root);
    return p;
}

// Sum of a_k H_k / (enter a_0): the Taylor series of the attenuation about
// h = 0 (eq 18, 22), s = sigma_a' for TT, 2 sigma_a' for TRT.
vec3 xu_energy(vec3 h, vec3 s, float inverse_eta2)
{
    vec3 x = s * inverse_eta2;
    return h.x + x * (h.y + (h.z * inverse_eta2) * (0.25 + 0.5 * s));
}

// Eq 16, 17.  With E = 1/2 enter T energy and b = g enter T, enter and T
// cancel in lambda_tt, which is therefore defined however dark the mode is.
XuTt xu_tt_lobe(XuPath p, float eta_column, float theta)
{
    vec2 at = xu_texel(vec2(eta_column, theta),
                       vec2(textureSize(xu_table_tt, 0)));
    vec3 energy =
        xu_energy(textureLod(xu_table_tt, at, 0.0).rgb, p.s, p.inverse_eta2);
    // eta' (eta' + 1) / (4 (eta'^2 - 1))
    float g = p.eta1 * (p.eta1 + 1.0) * p.c * p.c * (0.25 / p.square_1);
    vec3 k = 5.01325655 * g / energy; // sqrt(8 pi)
    return XuTt(g * p.enter, 2.0 * p.s, k * k);
}

// eta' >= 2: one lobe whose width grows from w_c to what N_TRT(0) asks for.
// t2 = T^2 at h = 0.
void xu_trt_single(Fibre f, XuPath p, vec3 t2, vec3 energy, inout XuTrt n)
{
    // N_TRT(0) = enter F t2 / (2 |4/eta' - 2|)
    float g = max(-p.over4, 0.0) / (0.886226925 * p.f * p.eta1 * (p.eta1 + 2.0));
    float t = clamp((p.eta1 - 2.0) / f.delta_eta, 0.0, 1.0);
    vec3 inverse = 1.0 / mix(vec3(f.w_c), energy * g, t * t * (3.0 - 2.0 * t));
    n.b = (0.282094792 * p.enter) * energy * t2 * inverse; // 1/(2 sqrt pi)
    n.b2 = vec3(0.0);
    n.kappa = 2.0 * inverse * inverse;
    n.cos_half = 1.0;
    n.sin_half = 0.0;
    n.three = false;
}

// eta' < 2: eq 20, 21.  With z = h*^2 = (4 - eta'^2)/3 the angle phi* has
// sin(phi*/2) = z^(3/2)/eta'^2 and cos(phi*/2) = sqrt(1-z) (4-z)/eta'^2.
void xu_trt_triple(Fibre f, XuPath p, vec3 t2, vec3 energy, inout XuTrt n)
{
    GUARD(GUARD_TRT_Z, p.over4 < 3e-6);
    float z = max(p.over4 * (1.0 / 3.0), 1e-6);
    n.sin_half = z * sqrt(z) * p.inverse_eta2;
    n.cos_half = sqrt(p.over1 * (1.0 / 3.0)) * (4.0 - z) * p.inverse_eta2;
    float angle = 4.0 * special_atan01(n.sin_half / (1.0 + n.cos_half));
    angle = max(angle, 1e-3); // nothing of b2 is left there
    // N_TRT(0) (eq 9): h = 0, and from eta' = sqrt 2 on the two h0 where
    // cos(gamma_i) = eta'^2/2 - 1 and cos(gamma_t) = eta'/2.
    vec3 peak = (0.25 * p.eta1 * (p.eta1 + 2.0) * p.enter * p.f) * t2;
    float side = max(0.5 * p.eta2 - 1.0, 0.0);
    float f1 = p.f0 + (1.0 - p.f0) * xu_fifth(1.0 - p.c * side);
    peak += (0.5 * p.eta2 * side * (1.0 - f1) * (1.0 - f1) * f1) *
            exp(-2.0 * p.eta1 * p.s);
    float inverse_w = 1.0 / f.w_c, sc = n.sin_half * inverse_w;
    float away = 1.0 - exp(-4.0 * sc * sc);
    n.b2 = peak * (away * away / (3.0 * z));
    vec3 rest = 0.5 * p.enter * energy * t2 - 1.77245385 * angle * n.b2;
    GUARD(GUARD_TRT_ANGLE, angle == 1e-3 && // with a millionth of the light
                               any(greaterThan(2e-3 * n.b2, 1e-6 * rest)));
    GUARD(GUARD_TRT_REST, lessThan(rest, vec3(0.0)));
    n.b = max(rest, 0.0) * (0.282094792 * inverse_w); // 1/(2 sqrt pi)
    float kc = 2.0 * inverse_w * inverse_w;
    n.kappa = vec3(kc, kc, 2.0 / (angle * angle));
    n.three = true;
}

XuTrt xu_trt_lobe(Fibre f, XuPath p, float eta_column, float theta)
{
    XuTrt n;
    vec2 at = xu_texel(vec2(eta_column, theta),
                       vec2(textureSize(xu_table_trt, 0)));
    vec3 energy = xu_energy(textureLod(xu_table_trt, at, 0.0).rgb, 2.0 * p.s,
                            p.inverse_eta2);
    vec3 t2 = exp(-4.0 * p.s);
    if (p.over4 > 0.0)
        xu_trt_triple(f, p, t2, energy, n);
    else
        xu_trt_single(f, p, t2, energy, n);
    return n;
}

// Eq 13, 14 with Schlick's F; f0 = F at normal incidence, c = cos theta_d.
float xu_n_r(float f0, XuLight l, XuPlace p)
{
    GUARD(GUARD_LAMBDA_WIDE, p.kappa < 0.02 && p.fall > 0.01);
    float column = xu_lambda_column(p.kappa), c = p.cos_d;
    vec3 odd = xu_cosine_odd(column, l.across);
    vec3 even = xu_cosine_even(column, l.across);
    float sum = 5.0 * odd.z - c * even.z;
    sum = 10.0 * odd.y + c * (-10.0 * even.y + c * sum);
    sum = odd.x + (1.0 - f0) * c * (-5.0 * even.x + c * sum);
    GUARD(GUARD_R_SUM, sum < 0.0);
    return max(sum, 0.0) * 0.5 * XU_PI * special_i0e(p.kappa);
}

vec3 xu_n_tt(XuTt n, XuLight l, float kappa)
{
    // The lobe stands at pi, so the half angle's sine and cosine change places.
    vec3 c2 = vec3(l.sin_half * l.sin_half), s2 = vec3(l.cos_half * l.cos_half);
    vec3 less, g = special_gauss_product(kappa, n.kappa, c2, s2, less);
    return (2.0 * XU_PI * n.b) * g * exp(-n.dark - less);
}

vec3 xu_n_trt(XuTrt n, XuLight l, float kappa)
{
    vec2 cc = n.cos_half * vec2(l.cos_half, l.sin_half);
    vec2 ss = n.sin_half * vec2(l.sin_half, l.cos_half);
    vec2 c = vec2(cc.x + ss.x, cc.x - ss.x); // cos((Phi -+ phi*)/2)
    vec2 s = vec2(cc.y - ss.y, cc.y + ss.y);
    vec3 c2 = vec3(c * c, l.cos_half * l.cos_half);
    vec3 s2 = vec3(s * s, l.sin_half * l.sin_half);
    vec3 less, g = special_gauss_product(kappa, n.kappa, c2, s2, less);
    g *= exp(-less);
    vec3 sum = n.three ? n.b * (g.x + g.y) + n.b2 * g.z : n.b * g;
    return 2.0 * XU_PI * sum;
}

#ifdef XU_ECCENTRIC
// The index that TRT takes for itself, minus 1: eq 24 averaged over the light
// (eq 26).  Its swing needs the mean of cos(phi_i' + phi_o + phi_j), which is
// 2 C_2/C_0 - 1 at the angle phi_o + phi_j.
float xu_eta_star_1(Fibre f, XuLight l, float kappa)
{
    float mean = 2.0 * xu_cosine_even(xu_lambda_column(kappa),
                                      l.turn_across).x - 1.0;
    float aa = f.a * f.a, inverse = 1.0 / aa;
    float turned = aa + inverse - 1.0 + mean * (aa - inverse);
    GUARD(GUARD_ETA_STAR, (f.eta - 1.0) * turned < 1e-4);
    return max((f.eta - 1.0) * turned, 1e-4);
}
#endif
