// fast.glsl - scattering of one light by one fibre from tables that are made
// once an edit: what the direct path integrates, to a percent, in a fraction of
// its time.  Include after xu.glsl.
//
// The product of a light's lobe and M_t is a Gaussian in theta_i whose mass is
// known (Xu 2011, eq 11); what is left, cos^2 theta_i / cos^2 theta_d times the
// inner integral of eq 12, is smooth.  The inner integral stands in the tables,
// over |theta_d|, ln lambda' and |Phi|: a cell holds value, gradient and second
// derivatives (of the channels' sum), so that a single cell gives the mean over
// the Gaussian to second order.  No light and no width of a lobe is known to the
// tables.  The last slice has eq 28's half circle in place of a light.
//   fast_modes      as xu_modes: M_R, M_TT, M_TRT
//   fast_globals    M^G of eq 27, by modes
//   fast_global     their sum
// Cells are made by fast_pack.comp; C side: renderer/fast_tables.h.
#include "fast_size.glsl"

layout(binding = 16) uniform usamplerBuffer fast_cells;

struct FastCell { // of three channels
    vec3 c, d, l, p;            // value and gradient, a cell being 1 long
    float dd, ll, pp, dl, dp, lp; // second order, in units of the value
};

float fast_high(uint bits) { return uintBitsToFloat(bits & 0xffff0000u); }
float fast_low(uint bits) { return uintBitsToFloat(bits << 16); }
float fast_byte(uint bits, int shift)
{
    return float(int(bits << shift) >> 24) * FAST_BYTE;
}

FastCell fast_open(uvec4 a, uvec4 b)
{
    FastCell f;
    f.c = vec3(fast_high(a.x), fast_low(a.x), fast_high(a.y));
    f.d = vec3(fast_low(a.y), fast_high(a.z), fast_low(a.z));
    f.l = vec3(fast_high(a.w), fast_low(a.w), fast_high(b.x));
    f.p = vec3(fast_low(b.x), fast_high(b.y), fast_low(b.y));
    f.dd = fast_high(b.z);
    f.ll = fast_byte(b.z, 16);
    f.pp = fast_byte(b.z, 24);
    f.dl = fast_byte(b.w, 0);
    f.dp = fast_byte(b.w, 8);
    f.lp = fast_byte(b.w, 16);
    return f;
}

FastCell fast_rgb(uint mode, uint cell)
{
    int at = int(2u * (mode * FAST_CELLS + cell));
    return fast_open(texelFetch(fast_cells, at), texelFetch(fast_cells, at + 1));
}

FastCell fast_grey(uint cell)
{
    uvec4 a = texelFetch(fast_cells, int(4u * FAST_CELLS + cell));
    FastCell f;
    f.c = vec3(fast_high(a.x));
    f.d = vec3(fast_low(a.x));
    f.l = vec3(fast_high(a.y));
    f.p = vec3(fast_low(a.y));
    f.dd = fast_high(a.z);
    f.ll = fast_byte(a.z, 16);
    f.pp = fast_byte(a.z, 24);
    f.dl = fast_byte(a.w, 0);
    f.dp = fast_byte(a.w, 8);
    f.lp = fast_byte(a.w, 16);
    return f;
}

// --- one mode at one place --------------------------------------------------
struct FastAt {
    uint cell;
    float d, l, p; // from the cell's middle
};

// l: the place in lambda', or the middle of the half circle's slice.
FastAt fast_at(float theta_d, float l, float across)
{
    float d = min(abs(theta_d) * FAST_PER_D, FAST_D - 1e-4);
    float p = min(across * FAST_P, FAST_P - 1e-4);
    vec3 at = vec3(d, l, p), i = floor(at), x = at - i - 0.5;
    return FastAt(uint((i.y * FAST_D + i.x) * FAST_P + i.z), x.x, x.y, x.z);
}

// Moments of what multiplies the table, over three Gauss-Hermite nodes at
// -1.22, 0 and 1.22 widths of the product: weight, and weight times products of
// the nodes' distances, in cells, from their mean, where the table is read.
struct FastMoments {
    vec3 whole, dd, dl, ll; // of R, TT, TRT
};
const float FAST_NODE = 1.22474487, FAST_MIDDLE = 2.0 / 3.0, FAST_SIDE = 1.0 / 6.0;

vec3 fast_sum(FastCell c, FastAt a, FastMoments m, int mode)
{
    float qd = 2.0 * c.dd * a.d + c.dl * a.l + c.dp * a.p;
    float ql = c.dl * a.d + 2.0 * c.ll * a.l + c.lp * a.p;
    float qp = c.dp * a.d + c.lp * a.l + 2.0 * c.pp * a.p;
    float q = 1.0 + 0.5 * (qd * a.d + ql * a.l + qp * a.p);
    float bend = m.dd[mode] * c.dd + m.dl[mode] * c.dl + m.ll[mode] * c.ll;
    return c.c * (m.whole[mode] * q + bend) +
           m.whole[mode] * (c.d * a.d + c.l * a.l + c.p * a.p);
}

// --- single scattering ------------------------------------------------------
// across: |Phi| / pi.  Components of vec3: R, TT, TRT.
struct FastLong {
    vec3 theta_d, l; // where the table is read
    FastMoments m;   // mass included
};

vec3 fast_cos(vec3 x)
{
    return vec3(special_cos(x.x), special_cos(x.y), special_cos(x.z));
}

// A node's weight: cos^2 theta_i, for R over cos^2 theta_d, and what the
// circular Gaussian has more than the plain one: exp of (x^2 - 4 sin^2(x/2)) /
// lambda^2, x from the light's centre, whose first terms are x^4/12 (1 - x^2/30).
// c: cos theta_i; cone: cos theta_d of R.
vec3 fast_weight(vec3 x, vec3 c, float cone, float per12)
{
    vec3 x2 = x * x, y = min(x2 * x2 * (per12 - (per12 / 30.0) * x2), 1.5);
    vec3 w = c * c;
    w.x = min(w.x / (cone * cone), 4.0);
    return w * (1.0 + y * (1.0 + y * (0.5 + y * (1.0 / 6.0))));
}

FastLong fast_long(Fibre f, Srbf light, float theta_o)
{
    FastLong g;
    vec3 w2 = 8.0 * f.beta * f.beta, apart = 2.0 * f.alpha - theta_o - light.theta;
    float light2 = light.lambda * light.lambda, per12 = 1.0 / (12.0 * light2);
    vec3 r2 = 1.0 / (w2 + light2), away = apart * (light2 * r2);
    vec3 mu = light.theta + away, step = FAST_NODE * sqrt(w2 * light2 * r2);
    vec3 mass = light.lambda * sqrt(r2) * exp(-apart * apart * r2);
    // cosines at the nodes; beyond +-pi/2 there is nothing
    vec3 c0 = fast_cos(mu - step), c1 = fast_cos(mu), c2 = fast_cos(mu + step);
    float d = 0.5 * (theta_o - mu.x), h = 0.5 * step.x;
    vec3 cone = max(fast_cos(vec3(d + h, d, d - h)), 1e-6);
    vec3 a = FAST_SIDE * fast_weight(away - step, c0, cone.x, per12);
    vec3 b = FAST_MIDDLE * fast_weight(away, c1, cone.y, per12);
    vec3 c = FAST_SIDE * fast_weight(away + step, c2, cone.z, per12);
    // ln lambda' at the nodes; its steps by ln x ~ 2 (x - 1)/(x + 1)
    c1 = max(c1, 0.02);
    vec3 lambda2 = light2 / (c1 * max(special_cos(light.theta), 1e-4));
    vec3 at = (0.5 * FAST_PER_LOG) * log(lambda2) - FAST_LOG_LEAST * FAST_PER_LOG;
    vec3 back = FAST_PER_LOG * (c1 - c0) / (c1 + c0);
    vec3 front = FAST_PER_LOG * (c1 - c2) / (c1 + c2);
    // narrower than the tables: as much less light
    mass *= min(sqrt(lambda2) * (1.0 / FAST_LEAST), 1.0);
    vec3 la = a * back, lc = c * front, sum = a + b + c;
    vec3 per = 1.0 / max(sum, 1e-20), mean = (c - a) * per, l = (la + lc) * per;
    g.theta_d = 0.5 * (theta_o - mu - mean * step);
    g.l = clamp(at + l, 0.0, FAST_L - 1e-4);
    vec3 move = (-0.5 * FAST_PER_D) * step * sign(g.theta_d);
    g.m.whole = mass * sum;
    g.m.dd = mass * move * move * (a + c - mean * mean * sum);
    g.m.dl = mass * move * (lc - la - mean * l * sum);
    g.m.ll = mass * (la * back + lc * front - l * l * sum);
    return g;
}

// M_t(omega_j, lambda_j) of eq 11; fast_modes_at: of what does not change with
// Phi.
void fast_modes_at(FastLong g, float across, out vec3 R, out vec3 TT,
                   out vec3 TRT)
{
    FastAt a = fast_at(g.theta_d.x, g.l.x, across);
    R = vec3(max(fast_sum(fast_grey(a.cell), a, g.m, 0).x, 0.0));
    TT = TRT = vec3(0.0);
#ifndef XU_NO_TT_TRT
    a = fast_at(g.theta_d.y, g.l.y, across);
    TT = max(fast_sum(fast_rgb(0u, a.cell), a, g.m, 1), 0.0);
    a = fast_at(g.theta_d.z, g.l.z, across);
    TRT = max(fast_sum(fast_rgb(1u, a.cell), a, g.m, 2), 0.0);
#endif
}

void fast_modes(Fibre f, Srbf light, float theta_o, float across, out vec3 R,
                out vec3 TT, out vec3 TRT)
{
    fast_modes_at(fast_long(f, light, theta_o), across, R, TT, TRT);
}

// --- multiple scattering ---------------------------------------------
// One mode, lobe: centre and width over theta_i.  The channels have their own
// sigma2, but share the nodes of the mean one: masses are exact, shift and width
// against it corrected to second order.
struct FastWide {
    vec3 node;               // theta_i
    vec3 weight;             // of the nodes
    vec3 mass, tilt, widen;  // a channel's
    float step;              // between nodes, in cells
};

FastWide fast_wide(float centre, float width, float theta_o, float theta_j,
                   vec3 sigma2)
{
    FastWide g;
    float w2 = width * width, apart = centre - theta_j;
    float s2 = dot(sigma2, vec3(1.0 / 3.0)), share = s2 / (w2 + s2);
    float l = width * sqrt(share), mu = theta_j + apart * share;
    g.node = mu + vec3(-FAST_NODE, 0.0, FAST_NODE) * l;
    g.weight = vec3(FAST_SIDE, FAST_MIDDLE, FAST_SIDE) * fast_cos(g.node);
    g.step = (mu > theta_o ? 0.5 : -0.5) * FAST_PER_D * FAST_NODE * l;
    vec3 root = inversesqrt(w2 + sigma2), own = root * root;
    vec3 change = sigma2 * own - share;
    g.mass = 0.564189584 * root * exp(-apart * apart * own);
    g.tilt = clamp(2.0 * apart / l * change, -1.0, 1.0);
    g.widen = min(change / share, 1.0) + 0.5 * g.tilt * g.tilt;
    return g;
}

// Sums of f, t f, (t^2 - 1/2) f over the nodes.
vec3 fast_wide_sum(FastCell c, FastAt a, FastWide g)
{
    float qd = 2.0 * c.dd * a.d + c.dp * a.p;
    float q = 1.0 + 0.5 * (qd * a.d + (c.dp * a.d + 2.0 * c.pp * a.p) * a.p);
    vec3 value = c.c * q + c.d * a.d + c.p * a.p;
    vec3 slope = g.step * (c.c * qd + c.d), bend = (g.step * g.step * c.dd) * c.c;
    vec3 back = g.weight.x * max(value - slope + bend, 0.0);
    vec3 middle = g.weight.y * max(value, 0.0);
    vec3 front = g.weight.z * max(value + slope + bend, 0.0);
    return g.mass * max(back + middle + front +
                            g.tilt * (FAST_NODE * (front - back)) +
                            g.widen * (back + front - 0.5 * middle),
                        0.0);
}

// M^G of eq 27 with psi_f of eq 5, R, TT, TRT; sigma2: square of psi_f's width.
void fast_globals(Fibre f, float theta_o, float theta_j, float across,
                  vec3 sigma2, out vec3 R, out vec3 TT, out vec3 TRT)
{
    vec3 centre = 2.0 * f.alpha - theta_o, width = 2.82842712 * f.beta;
    const float half_slice = float(FAST_HALF) + 0.5;
    FastWide g = fast_wide(centre.x, width.x, theta_o, theta_j, sigma2);
    FastAt a = fast_at(0.5 * (theta_o - g.node.y), half_slice, across);
    vec3 c = max(fast_cos(0.5 * (theta_o - g.node)), 1e-2);
    g.weight /= c * c;
    R = fast_wide_sum(fast_grey(a.cell), a, g);
    TT = TRT = vec3(0.0);
#ifndef XU_NO_TT_TRT
    g = fast_wide(centre.y, width.y, theta_o, theta_j, sigma2);
    a = fast_at(0.5 * (theta_o - g.node.y), half_slice, across);
    TT = fast_wide_sum(fast_rgb(0u, a.cell), a, g);
    g = fast_wide(centre.z, width.z, theta_o, theta_j, sigma2);
    a = fast_at(0.5 * (theta_o - g.node.y), half_slice, across);
    TRT = fast_wide_sum(fast_rgb(1u, a.cell), a, g);
#endif
}

// As dual_forward: what one crossing does to light from theta_j.
void fast_forward(float theta_j, out vec3 a_f, out vec3 betabar2_f)
{
    float at = (theta_j * (1.0 / XU_PI) + 0.5) * float(FAST_WAYS);
    int i = clamp(int(at), 0, int(FAST_WAYS) - 1);
    uvec4 b = texelFetch(fast_cells, int(5u * FAST_CELLS) + i);
    a_f = vec3(b.xyz >> 16) * (1.0 / 65535.0);
    vec3 beta = vec3(b.xyz & 0xffffu) * (FAST_BETA / 65535.0);
    betabar2_f = beta * beta;
}

vec3 fast_global(Fibre f, float theta_o, float theta_j, float across, vec3 sigma2)
{
    vec3 R, TT, TRT;
    fast_globals(f, theta_o, theta_j, across, sigma2, R, TT, TRT);
    return R + TT + TRT;
}
