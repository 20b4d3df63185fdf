// lit_column.glsl - a column of a light's table: the cells over Phi at one
// (s, theta_o).
// Include after lit.glsl.  Which of them are wanted is in `wanted`: first and, in
// the upper half, one past the last.
layout(binding = 22) uniform usamplerBuffer lit_wanted;

struct LitColumn {
    bool real;
    uint table, first, phis; // first: its cell with Phi = 0
    int s, d, rows, at;      // at: in lit_wanted
};

// Columns of all tables in one row: a table's rows of s, LIT_D columns each.
LitColumn lit_column(uint table, uint n)
{
    LitColumn c;
    uvec4 l = lit_table[table];
    const uint D = uint(LIT_D);
    c.table = table;
    c.rows = int(l.y >> 16);
    c.phis = lit_phis(l);
    c.s = int(n / D);
    c.d = int(n % D);
    c.real = c.s < c.rows;
    c.first = l.z + n * c.phis;
    c.at = int(table * lit_from.z + n);
    return c;
}

uvec2 lit_range(int at)
{
    uint w = texelFetch(lit_wanted, at).x;
    return uvec2(w & 0xffffu, w >> 16);
}

uvec2 lit_union(uvec2 a, uvec2 b)
{
    uvec2 both = uvec2(min(a.x, b.x), max(a.y, b.y));
    both = a.x < a.y ? both : b;
    return b.x < b.y ? both : a;
}

// What cells here and beside it read of this column: from, to.
uvec2 lit_reach(LitColumn c)
{
    int s0 = max(c.s - 1, 0) - c.s, s1 = min(c.s + 1, c.rows - 1) - c.s;
    int d0 = max(c.d - 1, 0) - c.d, d1 = min(c.d + 1, int(LIT_D) - 1) - c.d;
    uvec2 r = uvec2(0u);
    for (int s = s0; s <= s1; s++)
        for (int d = d0; d <= d1; d++)
            r = lit_union(r, lit_range(c.at + s * int(LIT_D) + d));
    if (r.x >= r.y)
        return uvec2(0u);
    uint from = r.y == c.phis ? min(r.x, c.phis - 3u) : r.x;
    return uvec2(from > 0u ? from - 1u : 0u, min(r.y + 1u, c.phis));
}

// theta_o, theta_j at the column's middle; within their range, where cells reach
// over the edge.
vec2 lit_theta(LitColumn c)
{
    float s = (float(c.s) + 0.5) / uintBitsToFloat(lit_table[c.table].x) - LIT_PI;
    float theta_o = lit_theta_o((float(c.d) + 0.5) / LIT_D);
    return vec2(theta_o, clamp(s - theta_o, -1.5706, 1.5706));
}
