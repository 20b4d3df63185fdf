// dual_paper.glsl - scheme `paper` of dual.glsl: Xu 2011, section 4.3 on the
// lobes of section 4.2, misprints corrected, approximations kept: plain
// Gaussians for half circles, the printed nodes, 1/cos theta_j (eq 27), means
// of shift and width over the light (eq 31).  Direct, not fast: it shows what
// the paper's method misses.  Channels share the nodes of the mean sigma_f.

struct DualView {
    float theta_o;
};

DualView dual_view(float theta_o)
{
    return DualView(theta_o);
}

// --- N^G (eq 28) ------------------------------------------------------------
vec3 dual_erf(vec3 t) // t >= 0
{
    vec3 e = exp(-t * t);
    return 1.0 - vec3(special_erfc(t.xy, e.xy), special_erfc(t.zz, e.zz).x);
}

// 1/pi of Int exp(-x^2/width^2) over half a circle d away, 0 <= d <= pi.
vec3 dual_half_gauss(vec3 width, vec3 d)
{
    vec3 near = abs(XU_HALF_PI - d), inverse = 1.0 / width;
    vec3 far = XU_PI - near;
    bvec3 beyond = greaterThan(d, vec3(XU_HALF_PI));
    vec3 a = dual_erf(near * inverse), b = dual_erf(far * inverse);
    // Beyond a quarter turn the two ends meet at the back of the circle.
    vec3 sum = mix(a + b, 2.0 * dual_erf(XU_PI * inverse) - a - b, beyond);
    GUARD(GUARD_DUAL_HALF, lessThan(sum, vec3(0.0)));
    return 0.282094792 * width * max(sum, 0.0);
}

// Int_0^x cos^k(t/2) dt for k = 1, 3, 5 and 2, 4, 6; 0 <= x <= pi.
void dual_cosine_to(float x, out vec3 odd, out vec3 even)
{
    float s = sin(0.5 * x), c = cos(0.5 * x), c2 = c * c;
    odd.x = 2.0 * s;
    odd.y = (2.0 / 3.0) * (c2 * s + odd.x);
    odd.z = 0.4 * c2 * c2 * s + 0.8 * odd.y;
    even.x = s * c + 0.5 * x;
    even.y = 0.5 * c2 * c * s + 0.75 * even.x;
    even.z = (1.0 / 3.0) * c2 * c2 * c * s + (5.0 / 6.0) * even.y;
}

struct DualPhi { // what one Phi says
    float away;     // |Phi|, in [0, pi]
    vec3 odd, even; // 1/pi of the half circle of |cos^k|: k = 1 3 5, 2 4 6
};

DualPhi dual_phi(float phi)
{
    DualPhi p;
    vec3 o0, e0, o1, e1, o2, e2;
    p.away = XU_PI * xu_across(phi);
    bool back = p.away > XU_HALF_PI;
    float near = abs(XU_HALF_PI - p.away);
    dual_cosine_to(near, o0, e0);
    dual_cosine_to(XU_PI - near, o1, e1);
    dual_cosine_to(XU_PI, o2, e2);
    p.odd = (back ? 2.0 * o2 - o0 - o1 : o0 + o1) * (1.0 / XU_PI);
    p.even = (back ? 2.0 * e2 - e0 - e1 : e0 + e1) * (1.0 / XU_PI);
    return p;
}

XuPlace dual_place(float theta_i, float theta_o)
{
    XuLight none;
    none.kappa = 0.0;
    return xu_place(theta_i, theta_o, none);
}

float dual_n_r(Fibre f, DualPhi phi, XuPlace p)
{
    float f0 = (f.eta - 1.0) / (f.eta + 1.0), c = p.cos_d;
    float sum = 5.0 * phi.odd.z - c * phi.even.z;
    sum = 10.0 * phi.odd.y + c * (-10.0 * phi.even.y + c * sum);
    sum = phi.odd.x + (1.0 - f0 * f0) * c * (-5.0 * phi.even.x + c * sum);
    GUARD(GUARD_DUAL_R, sum < 0.0);
    return 0.25 * max(sum, 0.0);
}

vec3 dual_n_tt(Fibre f, DualPhi phi, XuPlace p)
{
    XuPath path = xu_path(f.eta - 1.0, f.sigma_a, p.cos_d);
    XuTt n = xu_tt_lobe(path, xu_eta_column(f.eta), p.theta);
    return n.b * exp(-n.dark) *
           dual_half_gauss(sqrt(2.0 / n.kappa), vec3(XU_PI - phi.away));
}

vec3 dual_n_trt(Fibre f, DualPhi phi, XuPlace p)
{
    // Mean of eq 24 over all azimuths.
    float aa = f.a * f.a, eta_1 = (f.eta - 1.0) * (aa + 1.0 / aa - 1.0);
    XuPath path = xu_path(eta_1, f.sigma_a, p.cos_d);
    XuTrt n = xu_trt_lobe(f, path, xu_eta_column(eta_1 + 1.0), p.theta);
    vec3 width = sqrt(2.0 / n.kappa), away = vec3(phi.away);
    float angle = n.three ? width.z : 0.0; // phi*
    away.x = XU_PI * xu_across(phi.away - angle);
    away.y = XU_PI * xu_across(phi.away + angle);
    vec3 h = dual_half_gauss(width, away);
    return max(n.three ? n.b * (h.x + h.y) + n.b2 * h.z : n.b * h, 0.0);
}

// --- the integral over theta_i ----------------------------------------------
struct DualSum {
    vec3 r, tt, trt;
};

void dual_add(Fibre f, DualPhi phi, float theta_o, vec3 at, vec3 weight,
              inout DualSum sum)
{
    XuPlace p = dual_place(at.x, theta_o);
    sum.r += weight.x * p.fall * dual_n_r(f, phi, p);
#ifndef XU_NO_TT_TRT
    p = dual_place(at.y, theta_o);
    sum.tt += weight.y * p.fall * dual_n_tt(f, phi, p);
    p = dual_place(at.z, theta_o);
    sum.trt += weight.z * p.fall * dual_n_trt(f, phi, p);
#endif
}

vec3 dual_b(float theta) // A_b
{
    return dual_layer(theta, 2);
}

void dual_add_back(float theta_o, vec3 at, vec3 weight, inout vec3 sum)
{
    XuPlace p = dual_place(at.x, theta_o), q = dual_place(at.y, theta_o);
    XuPlace r = dual_place(at.z, theta_o);
    vec3 d = 0.5 * (at - theta_o);
    sum += weight * vec3(p.fall, q.fall, r.fall) *
           vec3(dual_b(d.x).x, dual_b(d.y).y, dual_b(d.z).z);
}

#ifdef XU_NODES_FOUR
DualSum dual_sum(Fibre f, DualPhi phi, XuLong g, float theta_o)
{
    vec3 a = xu_weights(g.lo.x, g.hi.x), b = xu_weights(g.lo.y, g.hi.y);
    vec3 c = xu_weights(g.lo.z, g.hi.z);
    DualSum sum = DualSum(vec3(0.0), vec3(0.0), vec3(0.0));
    dual_add(f, phi, theta_o, g.mu - g.width, vec3(a.x, b.x, c.x), sum);
    dual_add(f, phi, theta_o, g.mu, vec3(a.y, b.y, c.y), sum);
    dual_add(f, phi, theta_o, g.mu + g.width, vec3(a.z, b.z, c.z), sum);
    return sum;
}

vec3 dual_sum_back(XuLong g, float theta_o)
{
    vec3 a = xu_weights(g.lo.x, g.hi.x), b = xu_weights(g.lo.y, g.hi.y);
    vec3 c = xu_weights(g.lo.z, g.hi.z), sum = vec3(0.0);
    dual_add_back(theta_o, g.mu - g.width, vec3(a.x, b.x, c.x), sum);
    dual_add_back(theta_o, g.mu, vec3(a.y, b.y, c.y), sum);
    dual_add_back(theta_o, g.mu + g.width, vec3(a.z, b.z, c.z), sum);
    return sum;
}
#else
DualSum dual_sum(Fibre f, DualPhi phi, XuLong g, float theta_o)
{
    XuNodes n = xu_nodes_begin(g);
    vec3 t, weight;
    DualSum sum = DualSum(vec3(0.0), vec3(0.0), vec3(0.0));
    for (int s = 0; s < xu_m - 1; s++) {
        xu_nodes_next(n, g, s, t, weight);
        dual_add(f, phi, theta_o, g.mu + t * g.width, weight, sum);
    }
    return sum;
}

vec3 dual_sum_back(XuLong g, float theta_o)
{
    XuNodes n = xu_nodes_begin(g);
    vec3 t, weight, sum = vec3(0.0);
    for (int s = 0; s < xu_m - 1; s++) {
        xu_nodes_next(n, g, s, t, weight);
        dual_add_back(theta_o, g.mu + t * g.width, weight, sum);
    }
    return sum;
}
#endif

// Total mass of the product of two normalised Gaussians.
vec3 dual_mass(vec3 apart, vec3 both2)
{
    return 0.564189584 * inversesqrt(both2) * exp(-apart * apart / both2);
}

// Eq 29 without its azimuth and 1/cos theta_j, spread: Xu width of the light.
vec3 dual_back(float theta_o, float theta_j, vec3 spread)
{
    GUARD_LIVE(true);
    GUARD(GUARD_DUAL_RANGE, lessThan(spread, vec3(0.04)));
    vec3 mid = vec3(0.5 * (theta_j - theta_o)), half_range = max(0.5 * spread, 0.02);
    vec3 lo = clamp(mid - half_range, -XU_HALF_PI, XU_HALF_PI - 0.02);
    vec3 hi = clamp(mid + half_range, lo + 0.02, vec3(XU_HALF_PI));
    vec3 delta, sigma, range = 1.0 / (hi - lo);
    delta.x = dual_layer(hi.x, 3).x - dual_layer(lo.x, 3).x;
    delta.y = dual_layer(hi.y, 3).y - dual_layer(lo.y, 3).y;
    delta.z = dual_layer(hi.z, 3).z - dual_layer(lo.z, 3).z;
    sigma.x = dual_layer(hi.x, 4).x - dual_layer(lo.x, 4).x;
    sigma.y = dual_layer(hi.y, 4).y - dual_layer(lo.y, 4).y;
    sigma.z = dual_layer(hi.z, 4).z - dual_layer(lo.z, 4).z;
    delta *= range;
    GUARD(GUARD_DUAL_SIGMA, lessThan(sigma * range, vec3(1e-4)));
    sigma = max(sigma * range, 1e-4);
    vec3 w2 = 2.0 * sigma * sigma, s2 = spread * spread;
    vec3 apart = delta - theta_o - theta_j, both2 = w2 + s2;
    XuLong g;
    g.mu = theta_j + apart * s2 / both2;
    g.width = sqrt(w2 * s2 / both2);
    g.mass = 0.564189584 * dual_mass(apart, both2);
    g.lo = (-XU_HALF_PI - g.mu) / g.width;
    g.hi = (XU_HALF_PI - g.mu) / g.width;
    return g.mass * dual_sum_back(g, theta_o);
}

void dual_modes(Fibre f, DualView v, Srbf l, float phi_o, vec3 sigma_f,
                vec3 mask, out vec3 MG, out vec3 ML, out vec3 MLd)
{
    vec3 sigma2 = sigma_f * sigma_f, width = 2.82842712 * f.beta;
    vec3 apart = 2.0 * f.alpha - v.theta_o - l.theta;
    float mean = sqrt(dot(sigma2, vec3(1.0 / 3.0)));
    float phi = phi_o - l.phi;
    GUARD_LIVE(true);
    GUARD(GUARD_DUAL_GRAZING, special_cos(l.theta) < 1e-3);
    float over = 1.0 / max(special_cos(l.theta), 1e-3);
    XuLong g = xu_long(f, Srbf(l.theta, l.phi, mean), v.theta_o);
    DualSum sum = dual_sum(f, dual_phi(phi), g, v.theta_o);
    MG = mask.x * sum.r *
         dual_mass(vec3(apart.x), sigma2 + width.x * width.x);
    MG += mask.y * sum.tt *
          dual_mass(vec3(apart.y), sigma2 + width.y * width.y);
    MG += mask.z * sum.trt *
          dual_mass(vec3(apart.z), sigma2 + width.z * width.z);
    MG *= 0.564189584 * over;
    ML = dual_back(v.theta_o, l.theta, sigma_f) *
         (over * (1.0 - xu_across(phi)) * (1.0 / XU_PI)); // eq 30
    float c = special_cos(l.theta), kappa = 2.0 * c * c / (l.lambda * l.lambda);
    float i0e = special_i0e(kappa);
    MLd = dual_back(v.theta_o, l.theta, vec3(l.lambda)) *
          (3.5449077 * l.lambda * i0e * dual_half_share(kappa, i0e, cos(phi)));
}

// N^G_R, N^G_TT, N^G_TRT of the first channel.
vec3 dual_half(Fibre f, float theta_d, float phi)
{
    XuPlace p = dual_place(0.0, 2.0 * theta_d);
    DualPhi at = dual_phi(phi);
    return vec3(dual_n_r(f, at, p), dual_n_tt(f, at, p).x,
                dual_n_trt(f, at, p).x);
}
