// xu_nodes.glsl - the outer quadrature of Xu 2011, section 4.2.2: a Gaussian
// times a piecewise linear function.  Each node's weight, in units of
// Int exp(-t^2) dt; the two end nodes carry f = 0 (cos^2 theta_i) and none.
//
// Printed layout: m - 1 nodes one width apart, centred on the Gaussian, so that
// a larger m reaches farther out and never resolves more.  XU_FINE_NODES: nodes
// over +-min(4, sqrt((m-2)/2)) widths, moved inside the range where the centre
// lies outside, which grow denser with m.  At m = 4 both are the same.

const float XU_E1 = 0.367879441, XU_ERFC1 = 0.157299207;
const float XU_ROOT = 0.886226925; // sqrt(pi)/2

#ifdef XU_M
#if XU_M == 4 && !defined(XU_FINE_NODES)
#define XU_NODES_FOUR
#elif XU_M <= 6
#define XU_NODES_FEW
#endif
#endif

#ifdef XU_NODES_FOUR
// Nodes at t = -1, 0, 1.  All weights are constants but those towards the two
// ends of the range, which may cut into the nodes.

// An end at distance T from the centre, the node next to it at S < T, on the
// same side counted: the weight of a function that falls from 1 at S to 0 at T.
vec2 xu_towards_end(vec2 T, out vec2 S)
{
    bvec2 beyond = greaterThan(T, vec2(1.0)), outer = greaterThan(T, vec2(0.0));
    S = mix(mix(vec2(-1.0), vec2(0.0), outer), vec2(1.0), beyond);
    bvec2 centre = equal(S, vec2(0.0));
    vec2 es = mix(vec2(XU_E1), vec2(1.0), centre);
    vec2 qs = mix(vec2(XU_ERFC1), vec2(1.0), centre);
    vec2 et = exp(-T * T), qt = special_erfc(T, et);
    vec2 E = XU_ROOT * abs(qs - qt), J = 0.5 * (es - et), d = T - S;
    // Where T meets S, f at the node has vanished with cos^2 theta_i.
    return mix(E - (J - S * E) / max(d, 1e-3), 0.5 * E,
               lessThan(d, vec2(1e-3)));
}

// Weights of the three nodes; lo, hi: t at the ends of the range.
vec3 xu_weights(float lo, float hi)
{
    const float near = 0.430764084, far = 0.316060279; // of a whole segment
    const vec3 t = vec3(-1.0, 0.0, 1.0);
    vec2 S, end = xu_towards_end(vec2(-lo, hi), S);
    vec3 left = mix(vec3(0.0, near, far), vec3(end.x), equal(vec3(-S.x), t));
    vec3 right = mix(vec3(far, near, 0.0), vec3(end.y), equal(vec3(S.y), t));
    return (left + right) * vec3(lessThan(vec3(lo), t)) *
           vec3(lessThan(t, vec3(hi)));
}
#else
struct XuNodes { // the node before and the node at hand
    vec3 t0, t1;
    vec3 e0, e1, q0, q1; // exp(-t^2), erfc(|t|)
};

vec3 xu_node_at(XuLong g, int s)
{
    float half_span = 0.5 * float(xu_m - 2), x = float(s) - half_span;
    vec3 lo = g.lo, hi = g.hi;
    if (s == xu_m - 1)
        return hi;
#ifdef XU_FINE_NODES
    float w = min(4.0, sqrt(half_span)), share = 0.5 + 0.5 * x / max(half_span, 0.5);
    vec3 a = clamp(vec3(-w), lo, max(lo, hi - 2.0));
    vec3 b = clamp(vec3(w), min(hi, lo + 2.0), hi);
    return xu_m == 2 ? clamp(vec3(0.0), lo, hi) : mix(a, b, share);
#else
    return clamp(vec3(x), lo, hi);
#endif
}

vec3 xu_erfc(vec3 t, vec3 e)
{
    return vec3(special_erfc(t.xy, e.xy), special_erfc(t.zz, e.zz).x);
}

// Weight at t0 of the line that falls from 1 at t0 to 0 at t1, and of the one
// that rises.
void xu_segment(vec3 t0, vec3 t1, vec3 e0, vec3 e1, vec3 q0, vec3 q1,
                out vec3 fall, out vec3 rise)
{
    vec3 d = t1 - t0;
    bvec3 astride = lessThan(t0 * t1, vec3(0.0));
    vec3 E = XU_ROOT * mix(abs(q0 - q1), 2.0 - q0 - q1, astride);
    vec3 J = 0.5 * (e0 - e1);
    rise = (J - t0 * E) / max(d, 1e-3);
    fall = E - rise;
    // Short segments: 3-point Gauss-Legendre, where the above cancels.
    vec3 mid = 0.5 * (t0 + t1), off = 0.387298335 * d;
    vec3 ga = mid - off, gb = mid + off;
    vec3 va = (5.0 / 18.0) * exp(-ga * ga), vm = (4.0 / 9.0) * exp(-mid * mid);
    vec3 vb = (5.0 / 18.0) * exp(-gb * gb);
    bvec3 brief = lessThan(d, vec3(0.5));
    fall = mix(fall, d * (0.887298335 * va + 0.5 * vm + 0.112701665 * vb), brief);
    rise = mix(rise, d * (0.112701665 * va + 0.5 * vm + 0.887298335 * vb), brief);
}

XuNodes xu_nodes_begin(XuLong g)
{
    XuNodes n;
    n.t0 = g.lo;
    n.e0 = exp(-n.t0 * n.t0);
    n.q0 = xu_erfc(n.t0, n.e0);
    n.t1 = xu_node_at(g, 0);
    n.e1 = exp(-n.t1 * n.t1);
    n.q1 = xu_erfc(n.t1, n.e1);
    return n;
}

void xu_nodes_next(inout XuNodes n, XuLong g, int s, out vec3 t,
                   out vec3 weight)
{
    vec3 t2 = xu_node_at(g, s + 1), e2 = exp(-t2 * t2), q2 = xu_erfc(t2, e2);
    vec3 unused, rise, fall;
    xu_segment(n.t0, n.t1, n.e0, n.e1, n.q0, n.q1, unused, rise);
    xu_segment(n.t1, t2, n.e1, e2, n.q1, q2, fall, unused);
    t = n.t1;
    weight = max(rise, 0.0) + max(fall, 0.0);
    weight *= vec3(lessThan(g.lo, t)) * vec3(lessThan(t, g.hi));
    GUARD_LIVE(any(greaterThan(weight, vec3(0.0))));
    GUARD(GUARD_WEIGHT, lessThan(min(rise, fall), vec3(-1e-6)));
    n.t0 = n.t1;
    n.e0 = n.e1;
    n.q0 = n.q1;
    n.t1 = t2;
    n.e1 = e2;
    n.q1 = q2;
}
#endif
