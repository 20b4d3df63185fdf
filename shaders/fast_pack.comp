#version 450 core
// From values to cells: gradient and second derivatives by differences between
// neighbours, packed as fast.glsl reads them.
#include "fast_size.glsl"
#include "fast_bits.glsl"
layout(local_size_x = 64) in;
layout(binding = 20) uniform samplerBuffer value;
layout(std430, binding = 15) writeonly buffer Cells { uvec4 cells[]; };
const ivec3 SIZE = ivec3(FAST_D, FAST_L, FAST_P);

struct Pair {
    vec4 a, b; // TT and R; TRT
};

Pair at(ivec3 i)
{
    int n = 2 * ((i.y * SIZE.x + i.x) * SIZE.z + i.z);
    return Pair(texelFetch(value, n), texelFetch(value, n + 1));
}

// First and half the second difference along an axis.  The tables go on by
// symmetry at theta_d = 0 and Phi = 0; at other ends the parabola through the
// last three is taken, for at Phi = pi R has a fold.
void along(ivec3 i, ivec3 step, int place, int size, bool even, Pair here,
           out Pair first, out Pair second)
{
    bool start = place == 0, end = place == size - 1;
    ivec3 back = start ? (even ? i : i + 2 * step) : i - step;
    ivec3 front = end ? i - 2 * step : i + step;
    Pair p = at(back), q = at(front);
    if (start && !even) {
        first.a = 0.5 * (4.0 * q.a - 3.0 * here.a - p.a);
        first.b = 0.5 * (4.0 * q.b - 3.0 * here.b - p.b);
        second.a = 0.5 * (here.a - 2.0 * q.a + p.a);
        second.b = 0.5 * (here.b - 2.0 * q.b + p.b);
    } else if (end) {
        first.a = 0.5 * (3.0 * here.a - 4.0 * p.a + q.a);
        first.b = 0.5 * (3.0 * here.b - 4.0 * p.b + q.b);
        second.a = 0.5 * (here.a - 2.0 * p.a + q.a);
        second.b = 0.5 * (here.b - 2.0 * p.b + q.b);
    } else {
        first.a = 0.5 * (q.a - p.a);
        first.b = 0.5 * (q.b - p.b);
        second.a = 0.5 * (q.a + p.a) - here.a;
        second.b = 0.5 * (q.b + p.b) - here.b;
    }
}

vec3 sums(Pair p)
{
    return vec3(p.a.w, p.a.x + p.a.y + p.a.z, p.b.x + p.b.y + p.b.z);
}

// The mixed difference along two axes, of R, TT, TRT.
vec3 across(ivec3 i, ivec3 s, ivec3 t)
{
    ivec3 most = SIZE - 1, low = ivec3(0);
    if (i.y == int(FAST_HALF))
        low.y = most.y = i.y;
    ivec3 sp = clamp(i + s, low, most) - i, sm = clamp(i - s, low, most) - i;
    ivec3 tp = clamp(i + t, low, most) - i, tm = clamp(i - t, low, most) - i;
    ivec3 ds = sp - sm, dt = tp - tm;
    int area = (ds.x + ds.y + ds.z) * (dt.x + dt.y + dt.z);
    vec3 d = sums(at(i + sp + tp)) - sums(at(i + sp + tm)) -
             sums(at(i + sm + tp)) + sums(at(i + sm + tm));
    return area > 0 ? d / float(area) : vec3(0.0);
}

struct Second { // of R, TT, TRT, in units of the value
    vec3 dd, ll, pp, dl, dp, lp;
};

uvec2 second_bits(Second s, int mode)
{
    return uvec2(fast_bf16(s.dd[mode]) << 16 | fast_byte_of(s.ll[mode]) << 8 |
                     fast_byte_of(s.pp[mode]),
                 fast_byte_of(s.dl[mode]) << 24 | fast_byte_of(s.dp[mode]) << 16 |
                     fast_byte_of(s.lp[mode]) << 8);
}

void put_rgb(uint to, vec3 c, vec3 d, vec3 l, vec3 p, uvec2 second)
{
    cells[to] = uvec4(fast_two(c.x, c.y), fast_two(c.z, d.x), fast_two(d.y, d.z), fast_two(l.x, l.y));
    cells[to + 1u] = uvec4(fast_two(l.z, p.x), fast_two(p.y, p.z), second);
}

void main()
{
    uint n = gl_GlobalInvocationID.x;
    if (n >= FAST_CELLS)
        return;
    ivec3 i = ivec3(n / uint(SIZE.z) % uint(SIZE.x),
                    n / uint(SIZE.z * SIZE.x), n % uint(SIZE.z));
    const ivec3 X = ivec3(1, 0, 0), Y = ivec3(0, 1, 0), Z = ivec3(0, 0, 1);
    Pair c = at(i), d, l, p, dd, ll, pp;
    along(i, X, i.x, SIZE.x, true, c, d, dd);
    along(i, Z, i.z, SIZE.z, true, c, p, pp);
    l = ll = Pair(vec4(0.0), vec4(0.0));
    Second s;
    s.dl = s.lp = vec3(0.0);
    if (i.y < int(FAST_HALF)) {
        along(i, Y, i.y, SIZE.y, false, c, l, ll);
        s.dl = across(i, X, Y);
        s.lp = across(i, Y, Z);
    }
    s.dp = across(i, X, Z);
    vec3 per = 1.0 / max(sums(c), vec3(1e-20));
    s.dl *= per;
    s.lp *= per;
    s.dp *= per;
    s.dd = clamp(sums(dd) * per, -2.0, 2.0);
    s.ll = sums(ll) * per;
    s.pp = sums(pp) * per;
    put_rgb(2u * n, c.a.xyz, d.a.xyz, l.a.xyz, p.a.xyz, second_bits(s, 1));
    put_rgb(2u * (FAST_CELLS + n), c.b.xyz, d.b.xyz, l.b.xyz, p.b.xyz,
            second_bits(s, 2));
    cells[4u * FAST_CELLS + n] = uvec4(fast_two(c.a.w, d.a.w), fast_two(l.a.w, p.a.w),
                                       second_bits(s, 0));
}
