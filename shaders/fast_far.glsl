// fast_far.glsl - M^G as fast.glsl has it, but of wide light and lobes as well:
// the tables are read at each of five nodes within +-pi/2 (dual_rule of
// dual.glsl), instead of one cell that serves all.  Too dear for every light and
// place; the far table (lit_far_values.comp) is made with it.  One sigma_f for
// all channels.  Include after fast.glsl.

// What does not change with Phi.  Of one mode's nodes: where the tables are
// read, in cells of theta_d; weight, with all but N^G.
struct FastFarMode {
    vec4 d, weight;
    float d4, weight4; // the middle node
};
struct FastFar {
    FastFarMode r, tt, trt;
};

float fast_far_place(float theta_i, float theta_o)
{
    return min(abs(theta_o - theta_i) * (0.5 * FAST_PER_D), FAST_D - 1e-4);
}

FastFarMode fast_far_mode(float centre, float width, float theta_o,
                          float theta_j, float sigma2)
{
    FastFarMode g;
    float w2 = width * width, apart = centre - theta_j, both = 1.0 / (w2 + sigma2);
    float share = sigma2 * both, l = width * sqrt(share);
    float mu = theta_j + apart * share, per = 1.0 / l;
    float from = (-XU_HALF_PI - mu) * per, to = from + XU_PI * per;
    float lo = max(from, min(-1.985, to - 1.0));
    float hi = min(to, max(1.985, from + 1.0)), h = 0.5 * (hi - lo);
    const vec4 x = vec4(-0.906179846, -0.538469310, 0.538469310, 0.906179846);
    const vec4 w = vec4(0.236926885, 0.478628670, 0.478628670, 0.236926885);
    float t4 = 0.5 * (lo + hi), at4 = mu + l * t4;
    vec4 t = t4 + h * x, at = mu + l * t;
    float mass = (1.0 / XU_PI) * sqrt(both) * exp(-apart * apart * both) * h;
    g.weight4 = mass * 0.568888889 * exp(-t4 * t4) * special_cos(at4);
    g.weight = mass * w * exp(-t * t) *
               vec4(special_cos(at.x), special_cos(at.y), special_cos(at.z),
                    special_cos(at.w));
    g.d4 = fast_far_place(at4, theta_o);
    g.d = vec4(fast_far_place(at.x, theta_o), fast_far_place(at.y, theta_o),
               fast_far_place(at.z, theta_o), fast_far_place(at.w, theta_o));
    return g;
}

float fast_far_cone(float d)
{
    float c = max(special_cos(d * (1.0 / FAST_PER_D)), 1e-2);
    return 1.0 / (c * c);
}

FastFar fast_far_of(Fibre f, float theta_o, float theta_j, float sigma2)
{
    FastFar g;
    vec3 centre = 2.0 * f.alpha - theta_o, width = 2.82842712 * f.beta;
    g.r = fast_far_mode(centre.x, width.x, theta_o, theta_j, sigma2);
    g.r.weight4 *= fast_far_cone(g.r.d4);
    g.r.weight *= vec4(fast_far_cone(g.r.d.x), fast_far_cone(g.r.d.y),
                       fast_far_cone(g.r.d.z), fast_far_cone(g.r.d.w));
#ifndef XU_NO_TT_TRT
    g.tt = fast_far_mode(centre.y, width.y, theta_o, theta_j, sigma2);
    g.trt = fast_far_mode(centre.z, width.z, theta_o, theta_j, sigma2);
#endif
    return g;
}

// N^G at one node.  p: in cells of Phi.
vec3 fast_far_value(FastCell c, vec2 x)
{
    float q = 1.0 + (c.dd * x.x + c.dp * x.y) * x.x + c.pp * x.y * x.y;
    return max(c.c * q + c.d * x.x + c.p * x.y, 0.0);
}

vec3 fast_far_rgb(uint mode, float d, float p)
{
    vec2 i = floor(vec2(d, p));
    uint cell = uint((float(FAST_HALF) * FAST_D + i.x) * FAST_P + i.y);
    return fast_far_value(fast_rgb(mode, cell), vec2(d, p) - i - 0.5);
}

float fast_far_grey(float d, float p)
{
    vec2 i = floor(vec2(d, p));
    uint cell = uint((float(FAST_HALF) * FAST_D + i.x) * FAST_P + i.y);
    return fast_far_value(fast_grey(cell), vec2(d, p) - i - 0.5).x;
}

vec3 fast_far_sum(FastFarMode g, uint mode, float p)
{
    return g.weight.x * fast_far_rgb(mode, g.d.x, p) +
           g.weight.y * fast_far_rgb(mode, g.d.y, p) +
           g.weight4 * fast_far_rgb(mode, g.d4, p) +
           g.weight.z * fast_far_rgb(mode, g.d.z, p) +
           g.weight.w * fast_far_rgb(mode, g.d.w, p);
}

// across: |Phi| / pi.
vec3 fast_far_at(FastFar g, float across)
{
    float p = min(across * FAST_P, FAST_P - 1e-4);
    vec3 sum = vec3(dot(g.r.weight, vec4(fast_far_grey(g.r.d.x, p),
                                         fast_far_grey(g.r.d.y, p),
                                         fast_far_grey(g.r.d.z, p),
                                         fast_far_grey(g.r.d.w, p))) +
                    g.r.weight4 * fast_far_grey(g.r.d4, p));
#ifndef XU_NO_TT_TRT
    sum += fast_far_sum(g.tt, 0u, p) + fast_far_sum(g.trt, 1u, p);
#endif
    return sum;
}
