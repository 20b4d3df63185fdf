// lit.glsl - what each light does to a fibre, all modes added up: from tables
// that are made once an edit (lit_values.comp, lit_pack.comp, lit_far*.comp), so
// that a light costs a place one cell for what reaches it directly and one for
// what came forward through other fibres.  Include after fast.glsl.
//
//   s = theta_o + theta_j, along which lobes fall; theta_o; |Phi|.
//
// A light's table holds M_R + M_TT + M_TRT and its glow (fast_near.glsl).  The
// far table holds M^G and M^L (eq 27, 29) of one light scattered forward to
// width sigma_f: it knows no light, ln sigma_f is its fourth axis.  Cells are
// local quadratics as fast.glsl's.  C side: renderer/lit_tables.h.
#include "lit_size.glsl"
#include "guard.glsl"

layout(std140, binding = 9) uniform Lit {
    vec4 lit_far;   // first ln sigma_f; slices; rows of a slice; width^2
    uvec4 lit_from; // the far table's first texel; lights without a table; most
                    // columns of a table
    // its table: cells a radian of s (float); rows of s, cells over Phi, 16 bits
    // each; first cell.  lambda (float)
    uvec4 lit_light[200];
    uvec4 lit_rest[50]; // those lights, four a row
    uvec4 lit_table[200]; // the same of tables, which several lights may share
    uvec4 lit_groups; // how many groups of lights (lit_source.h)
    // lights group by group: the light; its weight (float); at a group's last one:
    // the group + 1
    uvec4 lit_member[200];
    vec4 lit_axis[200]; // of groups: direction, lambda
};

// A light's table, as one number has it (lit_source.c).
struct LitTable {
    float per_s, phis; // cells a radian of s; over |Phi|
    int first;         // cell
};

LitTable lit_unpack(uint bits)
{
    return LitTable(float(bits >> 4u & 1023u) * LIT_ROWS,
                    float((bits & 15u) * 4u),
                    int(bits >> 14u) * int(4.0 * LIT_D));
}

struct LitAt {
    int cell; // within a table
    vec3 x;   // from the cell's middle: s, theta_o, Phi
};

// theta_o as tables have it, 0 to 1: cells are 2.8 times as fine along the fibre,
// where cross sections bend most, as across it.  And back.
const float LIT_WARP = 0.6;
float lit_view(float theta_o)
{
    float x = theta_o * (2.0 / LIT_PI);
    return 0.5 + x * (0.5 + (0.5 * LIT_WARP) * x * x) * (1.0 / (1.0 + LIT_WARP));
}

float lit_theta_o(float view)
{
    float u = (2.0 * view - 1.0) * (1.0 + LIT_WARP), x = u / (1.0 + LIT_WARP);
    for (int i = 0; i < 5; i++) // Newton
        x -= (x * (1.0 + LIT_WARP * x * x) - u) / (1.0 + 3.0 * LIT_WARP * x * x);
    return x * (0.5 * LIT_PI);
}

// at: in cells; size: of theta_o and Phi.
LitAt lit_at(vec3 at, vec2 size)
{
    at = max(at, 0.0);
    at.yz = min(at.yz, size - 1e-3);
    vec3 i = floor(at);
    return LitAt(int((i.x * size.x + i.y) * size.y + i.z), at - i - 0.5);
}

uint lit_phis(uvec4 light) { return light.y & 0xffffu; }

// view: lit_view(theta_o).
vec3 lit_place(LitTable t, float s, float view, float across)
{
    return vec3((s + LIT_PI) * t.per_s, view * LIT_D, across * t.phis);
}

#ifndef LIT_WRITTEN
layout(binding = 21) uniform usamplerBuffer lit_cells;
// What a turn of the loops over lights needs, which from the block would cost
// more: a light's table and its radiance; after 200 of those the groups, lambda
// and flux.
layout(binding = 27) uniform usamplerBuffer lit_source;

vec4 lit_bytes(uint bits)
{
    return vec4(ivec4(bits, bits << 8, bits << 16, bits << 24) >> 24);
}

#ifdef GUARDS
bool lit_beyond(vec3 at, vec3 size)
{
    return any(lessThan(at, vec3(-1e-3))) || at.x >= size.x ||
           any(greaterThan(at.yz, size.yz + 1e-3));
}

// Has the middle of a cell, counted from 0, no theta_j?
bool lit_over(vec2 cell, float per_s, float views)
{
    float theta_o = lit_theta_o((cell.y + 0.5) / views);
    return abs((cell.x + 0.5) / per_s - LIT_PI - theta_o) > 0.5 * LIT_PI;
}

bvec4 lit_full(vec4 bytes) { return greaterThanEqual(abs(bytes), vec4(126.5)); }
#endif

vec3 lit_near(LitTable t, float s, float view, float across)
{
    vec3 place = lit_place(t, s, view, across);
    LitAt a = lit_at(place, vec2(LIT_D, t.phis));
    GUARD(GUARD_LIT_EDGE,
          lit_beyond(place, vec3(round(t.per_s / LIT_ROWS), LIT_D, t.phis)));
    GUARD(GUARD_LIT_OVER, lit_over(place.xy - a.x.xy - 0.5, t.per_s, LIT_D));
    int at = 2 * (t.first + a.cell);
    FastCell f = fast_open(texelFetch(lit_cells, at),
                           texelFetch(lit_cells, at + 1));
    vec3 x = a.x;
    float q = 1.0 + x.x * (f.dd * x.x + f.dl * x.y + f.dp * x.z) +
              x.y * (f.ll * x.y + f.lp * x.z) + f.pp * x.z * x.z;
    GUARD(GUARD_LIT_STEEP, abs(f.dd) >= 8.0);
    GUARD(GUARD_LIT_BEND, lit_full(vec4(f.ll, f.pp, f.dl, f.dp) / FAST_BYTE));
    GUARD(GUARD_LIT_BEND, abs(f.lp) > 126.5 * FAST_BYTE);
    GUARD(GUARD_LIT_LEAST, lessThan(f.c * q + f.d * x.x + f.l * x.y + f.p * x.z,
                                    -0.01 * f.c));
    return max(f.c * q + f.d * x.x + f.l * x.y + f.p * x.z, 0.0);
}

// A copy of the block: a value of it costs more than a multiplication inside the
// loop over lights.
struct LitFar {
    float first, most, rows, width2;
    int from;
};

LitFar lit_far_here()
{
    return LitFar(lit_far.x, lit_far.y - 1e-3, lit_far.z, lit_far.w,
                  int(lit_from.x));
}

// y: ln sigma_f of each channel, in slices; the cell is that of their mean.
struct LitFarAt {
    float slice, per_s; // cells a radian of s there
    LitAt at;           // within the slice
};

LitFarAt lit_far_place(LitFar f, float s, float view, float across, vec3 y)
{
    LitFarAt a;
    a.slice = floor(clamp(dot(y, vec3(1.0 / 3.0)), 0.0, f.most));
    float wide = exp(2.0 * f.first + (a.slice + 0.5) * (2.0 / LIT_FAR_LOG));
    a.per_s = inversesqrt(f.width2 + wide) * (1.0 / LIT_FAR_WIDTHS);
    a.per_s = min(a.per_s, f.rows * LIT_ROWS);
    a.at = lit_at(vec3((s + LIT_PI) * a.per_s, view * LIT_FAR_D,
                       across * LIT_FAR_P),
                  vec2(LIT_FAR_D, LIT_FAR_P));
    return a;
}

// log_sigma: of each channel.
vec3 lit_far_at(LitFar f, float s, float view, float across, vec3 log_sigma)
{
    vec3 y = (log_sigma - f.first) * LIT_FAR_LOG;
    LitFarAt place = lit_far_place(f, s, view, across, y);
    LitAt a = place.at;
    float slice = place.slice;
    int at = f.from + 2 * (int(slice * f.rows * (LIT_FAR_D * LIT_FAR_P)) + a.cell);
    uvec4 p = texelFetch(lit_cells, at), q = texelFetch(lit_cells, at + 1);
    vec3 x = a.x * FAST_BYTE, w = clamp(y - slice - 0.5, -2.0, 2.0);
    vec3 value = vec3(fast_high(p.x), fast_low(p.x), fast_high(p.y));
    vec4 by_s = lit_bytes(p.z), by_t = lit_bytes(p.w), by_p = lit_bytes(q.x);
    vec4 by_w = lit_bytes(q.y), bend = lit_bytes(q.z);
    float flat_part = 1.0 + fast_low(p.y) * a.x.x * a.x.x +
                      x.x * (by_p.w * a.x.y + by_w.w * a.x.z) +
                      x.y * (by_s.w * a.x.y + bend.x * a.x.z) +
                      x.z * by_t.w * a.x.z;
    float along = bend.y * x.x + bend.z * x.y + bend.w * x.z;
    GUARD(GUARD_LIT_FAR_EDGE,
          lit_beyond(vec3((s + LIT_PI) * place.per_s, view * LIT_FAR_D,
                          across * LIT_FAR_P),
                     vec3(f.rows, LIT_FAR_D, LIT_FAR_P)));
    GUARD(GUARD_LIT_FAR_OVER,
          lit_over(vec2((s + LIT_PI) * place.per_s, view * LIT_FAR_D) - a.x.xy -
                       0.5,
                   place.per_s, LIT_FAR_D));
    GUARD(GUARD_LIT_FAR_SIGMA,
          greaterThan(abs(y - slice - 0.5), vec3(2.0 + 1e-3)));
    GUARD(GUARD_LIT_FAR_STEEP, abs(fast_low(p.y)) >= 8.0);
    GUARD(GUARD_LIT_FAR_SLOPE, lit_full(vec4(by_s.xyz, 0.0)));
    GUARD(GUARD_LIT_FAR_SLOPE, lit_full(vec4(by_t.xyz, 0.0)));
    GUARD(GUARD_LIT_FAR_SLOPE, lit_full(vec4(by_p.xyz, 0.0)));
    GUARD(GUARD_LIT_FAR_SLOPE, lit_full(vec4(by_w.xyz, 0.0)));
    GUARD(GUARD_LIT_FAR_BEND, lit_full(vec4(by_s.w, by_t.w, by_p.w, by_w.w)));
    GUARD(GUARD_LIT_FAR_BEND, lit_full(vec4(bend.xyz, float(int(q.w) >> 24))));
    GUARD(GUARD_LIT_FAR_BEND, lit_full(vec4(bend.w)));
    vec3 rest = by_s.xyz * x.x + by_t.xyz * x.y + by_p.xyz * x.z +
                w * (by_w.xyz * FAST_BYTE + along +
                     float(int(q.w) >> 24) * FAST_BYTE * w);
    GUARD(GUARD_LIT_FAR_LEAST, lessThan(flat_part + rest, vec3(-0.01)));
    return value * max(flat_part + rest, 0.0);
}
#endif
