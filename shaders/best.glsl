// best.glsl - scheme `best`: single scattering of one SRBF light by one fibre
// (Xu 2011, eq 11), with a hundredth of the median error of scheme `paper` (sum
// of modes, typical fibres) in a third more time (docs/METHODS.md).  Include
// after xu.glsl, whose Fibre and Srbf it takes.
//
//   best_fibre()     what an edit made of the fibre, once a cell
//   best_modes(...)  M_R M_TT M_TRT for each colour channel
//
// theta_i: three nodes under the product of the light and M_t.  R, TT: four and
// five nodes of phi where the light falls on the lobe; N_R and N_TT are exact.
// TRT: the lobes of renderer/best_lobes.h.
// Variants: XU_ECCENTRIC, XU_NO_TT_TRT.
// Finite and >= 0 for every legal parameter and |theta| <= pi/2.
// Loops are written out, as in dual.glsl.

layout(std140, binding = 7) uniform Best {
    vec4 best_half[10];   // by powers of x: sin(phi/2) of the three panels
    vec4 best_spread[10]; // 1/kappa
    vec4 best_power[30];  // [panel][power]: energy in red, green, blue
    vec4 best_index;      // eta^2 - 1, 2 eta, eta, smallest 1/kappa
    vec4 best_turn;       // smallest eta* - 1, 1 / (largest - smallest)
};
#ifdef XU_ECCENTRIC
layout(binding = 4) uniform sampler2DArray best_turned; // over eta*, x
#endif

// A copy: a value of a block costs more than a multiplication inside the loop
// over lights.
struct BestFibre {
    vec3 halves[10], spread[10], power[30];
    vec4 index;
};

#define BEST_LOAD_5(to, from, i)                                               \
    to[i] = from[i].xyz;                                                       \
    to[i + 1] = from[i + 1].xyz;                                               \
    to[i + 2] = from[i + 2].xyz;                                               \
    to[i + 3] = from[i + 3].xyz;                                               \
    to[i + 4] = from[i + 4].xyz
#define BEST_LOAD_10(to, from, i)                                              \
    BEST_LOAD_5(to, from, i);                                                  \
    BEST_LOAD_5(to, from, i + 5)

BestFibre best_fibre()
{
    BestFibre b;
    BEST_LOAD_10(b.halves, best_half, 0);
    BEST_LOAD_10(b.spread, best_spread, 0);
    BEST_LOAD_10(b.power, best_power, 0);
    BEST_LOAD_10(b.power, best_power, 10);
    BEST_LOAD_10(b.power, best_power, 20);
    b.index = best_index;
    return b;
}

struct BestLight {
    float kappa;              // kappa' = kappa cos(theta_i)
    float across;             // |Phi| in [0, pi]
    float cos_half, sin_half; // of half of that
    float turned;             // cos(phi_o + phi_j)
};

BestLight best_light(Srbf l, float phi_o)
{
    BestLight x;
    x.kappa = 2.0 * max(special_cos(l.theta), 0.0) / (l.lambda * l.lambda);
    x.across = XU_PI * xu_across(phi_o - l.phi);
    x.cos_half = special_cos(0.5 * x.across);
    x.sin_half = special_sin(0.5 * x.across);
    x.turned = 0.0;
#ifdef XU_ECCENTRIC
    x.turned = cos(phi_o + l.phi);
#endif
    return x;
}

// --- theta_i ----------------------------------------------------------------
// The three-node Gauss rule of exp(-t^2) on what +-pi/2 leave of it.  The end
// next to the centre is b widths away, the other one far: the nodes' distances
// from the near end and their weights, e^(t^2) with them, are polynomials in a
// function of b, and more where the far end cuts as well; within .4 % for b from
// -4 on and pi at least 3.3 widths (docs/METHODS.md).
struct BestRule {
    vec3 theta, weight;
};

// Exact at b = 3, so that both ends may change their parts there.
void best_nodes(float b, float far, out vec3 off, out vec3 weight)
{
    float x = 14.0 - 600.0 / (b + sqrt(b * b + 3.5) + 40.0);
    float y = max(3.2 - far, 0.0);
    y *= 0.03 * y * y;
    vec3 d = vec3(-0.0561984148, -0.0511987197, -0.224692499);
    d = vec3(-0.081976159, 0.0766862622, 0.391344167) + d * x;
    d = vec3(0.0324523719, -0.10768948, -0.167877353) + d * x;
    d = vec3(0.329064629, 0.127452352, 0.090311504) + d * x;
    d = vec3(0.483233397, 0.337635062, 0.0878800553) + d * x;
    d = vec3(0.542376533, 1.20075159, 1.54190251) + d * x;
    d = vec3(0.327911061, 1.2132795, 2.30337437) + d * x;
    vec3 e = vec3(0.17677429, 1.55697808, 3.43608723) +
             x * vec3(-0.514997213, -1.50645896, -2.41733146);
    off = d + y * (vec3(-0.495164001, -1.4285611, -3.23027408) + e * x);
    d = vec3(0.16897018, -0.0799095403, -0.249961998);
    d = vec3(0.129464552, 0.184109524, 0.461343596) + d * x;
    d = vec3(-0.4674801, -0.0553943251, -0.106076681) + d * x;
    d = vec3(-0.376755548, -0.0325276263, -0.0805737749) + d * x;
    d = vec3(0.230900911, -0.274398602, -0.19374552) + d * x;
    d = vec3(0.904205405, 0.447217143, 0.270637769) + d * x;
    d = vec3(0.727020559, 0.991134031, 1.22340038) + d * x;
    e = vec3(2.25911112, 1.28938911, 2.40868282) +
        x * vec3(-1.82514626, -0.762494884, -0.903969775);
    weight = d + y * (vec3(-1.13802318, -1.04776502, -3.16099929) + e * x);
}

// D^2 - 4 sin^2(D/2), |D| <= pi; relative error 2e-3 at pi, 1e-6 below 1.2
vec3 best_bend(vec3 d)
{
    vec3 u = d * d;
    vec3 p = 1.0 / 20160.0 - u * (1.0 / 1814400.0 - u * (1.0 / 239500800.0));
    return u * u * (1.0 / 12.0 + u * (p * u - 1.0 / 360.0));
}

// The light is circular in theta, and falls off less than a plain Gaussian:
// the rule stands at the top of its product with M_t, after one step of Newton's
// from that of the plain product, and is as wide as the product is there.  What
// the product itself is at a node is exact.
BestRule best_rule(float beta, float alpha, Srbf l, float theta_o)
{
    float w = 2.82842712 * beta, apart = 2.0 * alpha - theta_o - l.theta;
    float w2 = w * w, l2 = l.lambda * l.lambda, r2 = 1.0 / (w2 + l2);
    float d = apart * l2 * r2, u = min(d * d, 6.0);
    float less = d * u * (1.0 / 6.0 - u * (1.0 / 120.0 - u * (1.0 / 5040.0)));
    float slope = max(1.0 - u * (0.5 - u * (1.0 / 24.0)), 0.0);
    float shift = less * w2 / (slope * w2 + l2);
    float mu = l.theta + d + shift;
    u = min((d + shift) * (d + shift), 6.0);
    slope = max(1.0 - u * (0.5 - u * (1.0 / 24.0 - u * (1.0 / 720.0))), 0.0);
    float width = w * l.lambda * inversesqrt(slope * w2 + l2);
    width = min(width, XU_PI / 3.3);
    float per = 1.0 / width, centre = min(abs(mu), XU_HALF_PI + 4.0 * width);
    float b = min((XU_HALF_PI - centre) * per, 3.0);
    vec3 off, weight;
    best_nodes(b, (XU_HALF_PI + centre) * per, off, weight);
    vec3 from = width * (b - off) + (centre - abs(mu)); // theta_i - mu
    from = mu < 0.0 ? -from : from;
    BestRule n;
    n.theta = clamp(mu + from, -XU_HALF_PI, XU_HALF_PI);
    from += shift;
    vec3 more = best_bend(n.theta - l.theta) / l2;
    vec3 less_t = apart * apart * r2 + from * from / (w2 * l2 * r2);
    // 1/sqrt(pi) of M_t
    n.weight = (0.564189584 * width / w) * weight * exp(min(more - less_t, 0.0));
    return n;
}

// special_i0 where 1/x is known: a division less
vec3 best_i0(vec3 x, vec3 per, out vec3 rest)
{
    vec3 z = min(x * x * (2.0 / 20.25) - 1.0, 1.0);
    vec3 low = 0.010936114 + 0.000725538646 * z;
    low = 0.115956546 + low * z;
    low = 0.81885275 + low * z;
    low = 3.46131635 + low * z;
    low = 7.4107965 + low * z;
    low = 5.66258748 + low * z;
    vec3 r2 = min(per, 1.0 / 4.5), y = 9.0 * r2 - 1.0;
    vec3 high = 0.000115092952 + 3.05433091e-05 * y;
    high = 0.000540871668 + high * y;
    high = 0.00639212006 + high * y;
    high = 0.404878338 + high * y;
    bvec3 small = lessThan(x, vec3(4.5));
    rest = mix(vec3(0.0), x, small);
    return mix(high * sqrt(r2), low, small);
}

struct BestPlace { // what one theta_i says
    float kappa;    // 2 / lambda'^2
    float lambda;   // lambda'
    float cos_i;
    float cos_d;
    float root;     // eta' cos theta_d
};

BestPlace best_place(float theta_i, float theta_o, BestFibre b, BestLight l)
{
    BestPlace p;
    p.cos_i = special_cos(theta_i);
    GUARD_LIVE(abs(theta_i) < XU_HALF_PI); // else nothing comes of it
    GUARD(GUARD_COS_D, special_cos(0.5 * (theta_o - theta_i)) < 1e-6);
    GUARD(GUARD_FLAT, p.cos_i > 1e-6 && 0.5 * l.kappa * p.cos_i < 1e-12);
    p.cos_d = max(special_cos(0.5 * (theta_o - theta_i)), 1e-6);
    p.kappa = l.kappa * p.cos_i;
    p.lambda = inversesqrt(max(0.5 * p.kappa, 1e-12));
    p.root = sqrt(b.index.x + p.cos_d * p.cos_d);
    return p;
}

// --- R ----------------------------------------------------------------------
// N_R = 1/4 |cos(phi/2)| F is even in phi, so that the light is folded into
// [0, pi]; the mean of N_R under it, four nodes over Phi +-1.85 lambda', times
// its mass, which is known.
// special_i0e of kappa = 2/lambda^2
float best_i0e(float x, float lambda)
{
    vec3 rest, v = best_i0(vec3(x), vec3(0.5 * lambda * lambda), rest);
    return v.x * exp(-rest.x);
}

float best_r(BestPlace p, BestLight l, float square)
{
    const vec4 node = vec4(-0.861136312, -0.339981044, 0.339981044, 0.861136312);
    const vec4 share = vec4(0.347854845, 0.652145155, 0.652145155, 0.347854845);
    float reach = 1.85 * p.lambda, a = max(-l.across, -reach);
    float b = min(XU_PI - l.across, reach);
    vec4 x = 0.25 * (a + b) + 0.25 * (b - a) * node; // half the offset from Phi
    vec4 s = special_sin(x), c = special_cos(x);
    vec4 far = 2.0 * l.sin_half * l.cos_half * c +
               (1.0 - 2.0 * l.sin_half * l.sin_half) * s; // sin(Phi + x)
    vec4 u = max(l.cos_half * c - l.sin_half * s, 0.0);   // cos(phi/2)
    float k = -2.88539008 * p.kappa; // for powers of 2
    vec4 g = share * (exp2(k * s * s) + exp2(k * far * far));
    vec4 ci = p.cos_d * u, root = sqrt(square + ci * ci);
    vec4 n = (square + 1.0) * ci;
    vec4 x1 = ci + root, y1 = n + root; // 2 F over one denominator
    vec4 across = (ci - root) * y1, along = (n - root) * x1;
    x1 *= y1;
    vec4 f = u * (across * across + along * along) / (x1 * x1);
    float mean = dot(g, f) / dot(g, vec4(1.0));
    float fall = p.cos_i / p.cos_d;
    GUARD(GUARD_FALL, fall * fall > 4.0);
    // 2 pi / 8
    return 0.785398163 * min(fall * fall, 4.0) * best_i0e(p.kappa, p.lambda) * mean;
}

float best_sum_r(BestRule n, float theta_o, BestFibre b, BestLight l)
{
    vec3 v =
        vec3(best_r(best_place(n.theta.x, theta_o, b, l), l, b.index.x),
             best_r(best_place(n.theta.y, theta_o, b, l), l, b.index.x),
             best_r(best_place(n.theta.z, theta_o, b, l), l, b.index.x));
    return dot(n.weight, v);
}

// --- TT ---------------------------------------------------------------------
// With delta = |phi - pi|, eq 8 turns around without a root: gamma_t has
//   tan gamma_t = sin(delta/2) / (eta' - cos(delta/2)),
// hence D^2 = eta'^2 - 2 eta' cos(delta/2) + 1, D cos gamma_t = eta' -
// cos(delta/2), D cos gamma_i = eta' cos(delta/2) - 1 and
//   N_TT = 1/4 (1-F)^2 T eta' cos gamma_i cos gamma_t / D,
// zero where cos gamma_i is.  co, so: cosine and sine of half the offset from
// the light; the result has cos^2 theta_i / cos^2 theta_d but for cos^2 theta_i.
struct BestTt {
    float eta1, cos_near, sin_near; // of half the light's delta
    float sin_full, cos_full;       // of all of it
};

// x: what the node adds to the colourless integral; yz: that times cos gamma_t
// and its square.
vec3 best_tt_node(BestTt n, BestPlace p, float half_offset, float eta2)
{
    float so = special_sin(half_offset), co = special_cos(half_offset);
    float c = n.cos_near * co - n.sin_near * so; // of delta/2
    float s = n.sin_near * co + n.cos_near * so;
    float far = n.sin_full * co + n.cos_full * so;
    float k = -2.88539008 * p.kappa; // for powers of 2
    float lit = exp2(k * so * so) + exp2(k * far * far);
    float inside = n.eta1 - c, outside = max(n.eta1 * c - 1.0, 0.0);
    // 1 - F = 2 a q (1/(a+q)^2 + eta^2/(eta^2 a+q)^2), a = cos theta_d cos
    // gamma_i, q = root cos gamma_t: no less with D a and D q
    float q = p.root * inside, a = p.cos_d * outside;
    float x = a + q, y = eta2 * a + q, xx = x * x, yy = y * y, both = xx * yy;
    float D = sqrt(inside * inside + s * s), one = 1.0 / (both * D);
    float per = both * one, ct = inside * per;
    float enter = outside * q * (yy + eta2 * xx) * one;
    float v = lit * enter * enter * outside * ct;
    return vec3(v, v * ct, v * ct * ct);
}

// Absorption varies little along what one light sees of the lobe: its mean is
// taken to second order in the spread of cos gamma_t, for each colour.
vec3 best_tt(BestPlace p, BestFibre b, BestLight l, vec3 sigma_a)
{
    BestTt n;
    float over_root = 1.0 / p.root, eta2 = b.index.x + 1.0;
    n.eta1 = p.root / p.cos_d;
    // the light stands at pi - |Phi|
    n.cos_near = l.sin_half;
    n.sin_near = l.cos_half;
    n.sin_full = 2.0 * l.sin_half * l.cos_half;
    n.cos_full = 2.0 * l.sin_half * l.sin_half - 1.0;
    float near = XU_PI - l.across;
    float last = XU_PI - 2.0 * special_asin(p.cos_d * over_root);
    float hi = min(last - near, 2.1 * p.lambda);
    float lo = max(-near, min(-2.1 * p.lambda, hi - 3.2 * p.lambda));
    float mid = 0.25 * (lo + hi), h = 0.25 * (hi - lo);
    float x = 0.906179846 * h, y = 0.538469310 * h;
    vec3 sum = 0.568888889 * best_tt_node(n, p, mid, eta2) +
               0.478628670 * (best_tt_node(n, p, mid - y, eta2) +
                              best_tt_node(n, p, mid + y, eta2)) +
               0.236926885 * (best_tt_node(n, p, mid - x, eta2) +
                              best_tt_node(n, p, mid + x, eta2));
    float per = 1.0 / max(sum.x, 1e-37), ct = sum.y * per;
    float spread = max(sum.z * per - ct * ct, 0.0);
    vec3 dark = (2.0 * b.index.z * over_root) * sigma_a;
    return (2.0 * h * p.cos_i * p.cos_i * n.eta1 * sum.x) *
           (exp(-dark * ct) * (1.0 + (0.5 * spread) * dark * dark));
}

vec3 best_sum_tt(BestRule n, float theta_o, BestFibre b, BestLight l, vec3 s)
{
    return n.weight.x * best_tt(best_place(n.theta.x, theta_o, b, l), b, l, s) +
           n.weight.y * best_tt(best_place(n.theta.y, theta_o, b, l), b, l, s) +
           n.weight.z * best_tt(best_place(n.theta.z, theta_o, b, l), b, l, s);
}

// --- TRT --------------------------------------------------------------------
// Horner's scheme over ten powers.
#define BEST_POLY(v, i, x)                                                     \
    (v[i] +                                                                    \
     x * (v[i + 1] +                                                           \
          x * (v[i + 2] +                                                      \
               x * (v[i + 3] +                                                 \
                    x * (v[i + 4] +                                            \
                         x * (v[i + 5] +                                       \
                              x * (v[i + 6] +                                  \
                                   x * (v[i + 7] +                             \
                                        x * (v[i + 8] + x * v[i + 9])))))))))

#ifdef XU_ECCENTRIC
// I_1/I_0: four steps of Gauss's continued fraction and Amos's bound; 3e-5.
float best_bessel_ratio(float k)
{
    float r = k / (4.5 + sqrt(30.25 + k * k));
    r = k / (8.0 + k * r);
    r = k / (6.0 + k * r);
    r = k / (4.0 + k * r);
    return k / (2.0 + k * r);
}

// eta* - 1 averaged over the light (eq 24, 26), as a place in the texture.
float best_column(Fibre f, BestLight l, float kappa)
{
    float mean = best_bessel_ratio(kappa) * l.turned;
    float aa = f.a * f.a, inverse = 1.0 / aa;
    float turned = aa + inverse - 1.0 + mean * (aa - inverse);
    return clamp(((f.eta - 1.0) * turned - best_turn.x) * best_turn.y, 0.0, 1.0);
}
#endif

// special_gauss_product with half as many divisions
vec3 best_product(float k1, vec3 k2, vec3 sin2, out vec3 less)
{
    vec3 four = 4.0 * k1 * k2, sum = k1 + k2, apart = k1 - k2, rest;
    // sin2, rounded, may be above 1
    vec3 k = sqrt(apart * apart + four * max(1.0 - sin2, 0.0)) + 1e-12;
    vec3 one = 1.0 / (k * (k + sum));
    vec3 i0 = best_i0(k, one * (k + sum), rest);
    GUARD(GUARD_GAUSS_FLAT, lessThan(k + sum, vec3(1e-22)));
    less = rest + four * sin2 * (one * k);
    return i0;
}

vec3 best_trt(Fibre f, BestPlace p, BestFibre b, BestLight l)
{
    float x = b.index.y * p.cos_d / p.root - 1.0;
    vec3 s, v;
#ifdef XU_ECCENTRIC
    vec2 at = vec2(best_column(f, l, p.kappa), 0.5 + 0.5 * x);
    at = xu_texel(at, vec2(textureSize(best_turned, 0).xy));
    s = textureLod(best_turned, vec3(at, 0.0), 0.0).xyz;
    v = textureLod(best_turned, vec3(at, 1.0), 0.0).xyz;
#else
    s = BEST_POLY(b.halves, 0, x);
    v = BEST_POLY(b.spread, 0, x);
#endif
    GUARD(GUARD_BEST_SINE, greaterThan(abs(s), vec3(1.0001)));
    GUARD(GUARD_BEST_SPREAD, lessThan(v, vec3(b.index.w)));
    GUARD(GUARD_BEST_POWER, // one of the three against the sum
          lessThan(min(min(BEST_POLY(b.power, 0, x), BEST_POLY(b.power, 10, x)),
                       BEST_POLY(b.power, 20, x)),
                   -0.01 * (BEST_POLY(b.power, 0, x) +
                            BEST_POLY(b.power, 10, x) +
                            BEST_POLY(b.power, 20, x))));
    s = clamp(s, -1.0, 1.0);
    vec3 c = sqrt(1.0 - s * s), k = 1.0 / max(v, b.index.w);
    // sines of half the angles between light and lobes, phi and -phi
    vec3 one = l.sin_half * c - l.cos_half * s;
    vec3 two = l.sin_half * c + l.cos_half * s;
    one *= one;
    two *= two;
    vec3 less_one, less_two;
    vec3 g = best_product(p.kappa, k, one, less_one);
    vec3 h = best_product(p.kappa, k, two, less_two);
    vec3 lobe = g * exp(-less_one) + h * exp(-less_two);
#ifdef XU_ECCENTRIC
    vec3 rest, own = best_i0(k, 1.0 / k, rest);
    lobe *= 1.0 / (own * exp(-rest));
#else
    lobe *= sqrt(k);
#endif
    return (p.cos_i * p.cos_i) *
           (lobe.x * max(BEST_POLY(b.power, 0, x), 0.0) +
            lobe.y * max(BEST_POLY(b.power, 10, x), 0.0) +
            lobe.z * max(BEST_POLY(b.power, 20, x), 0.0));
}

vec3 best_sum_trt(Fibre f, BestRule n, float theta_o, BestFibre b, BestLight l)
{
    return n.weight.x * best_trt(f, best_place(n.theta.x, theta_o, b, l), b, l) +
           n.weight.y * best_trt(f, best_place(n.theta.y, theta_o, b, l), b, l) +
           n.weight.z * best_trt(f, best_place(n.theta.z, theta_o, b, l), b, l);
}

void best_modes(Fibre f, BestFibre b, Srbf l, float theta_o, float phi_o,
                out vec3 R, out vec3 TT, out vec3 TRT)
{
    BestLight x = best_light(l, phi_o);
    R = vec3(best_sum_r(best_rule(f.beta.x, f.alpha.x, l, theta_o), theta_o, b,
                        x));
    TT = TRT = vec3(0.0);
#ifndef XU_NO_TT_TRT
    TT = best_sum_tt(best_rule(f.beta.y, f.alpha.y, l, theta_o), theta_o, b, x,
                     f.sigma_a);
    TRT = best_sum_trt(f, best_rule(f.beta.z, f.alpha.z, l, theta_o), theta_o,
                       b, x);
#endif
}
