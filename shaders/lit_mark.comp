#version 450 core
// Keeps what lights and places are to each other, and marks the cells of lights'
// tables that they read: those whose light is not blocked.
#include "shade.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint kept;
layout(std430, binding = 13) writeonly buffer Marks { uint marks[]; };
#ifdef LIT_NEW
layout(std430, binding = 12) writeonly buffer Directs { uvec2 directs[]; };
layout(std430, binding = 14) writeonly buffer Records { uvec4 records[]; };
layout(std430, binding = 15) buffer Order { uvec2 order[]; };
#endif

void mark(LitTable t, vec3 place)
{
    LitAt a = lit_at(place, vec2(LIT_D, t.phis));
    marks[t.first + a.cell] = 1u;
}

void mark_at(LitDirect l, float theta_o, float view)
{
    uint table = texelFetch(lit_source, int(l.light)).x;
    if (table == 0u)
        return;
    LitTable t = lit_unpack(table);
    vec3 place = lit_place(t, theta_o + l.theta_j, view, l.across);
    mark(t, place + 1e-3);
    // Both sides of an edge: another program may round otherwise.
    if (any(greaterThan(abs(fract(place) - 0.5), vec3(0.499))))
        mark(t, place - 1e-3);
}

void main()
{
    uint row = gl_NumWorkGroups.x * 64u;
    uint at = gl_GlobalInvocationID.x + gl_WorkGroupID.y * row;
    uint entry = dispatch.w + at;
#ifdef SHADOW_STORED
    if (at >= nodes_stride)
        return;
    entry += nodes_begin;
#endif
#ifdef LIT_KEPT
    entry -= at;
    at = lit_unsorted(at);
    entry += at;
#endif
    if (entry >= list_end[kept])
        return;
    Place c = place_of(list[entry]);
    vec3 to_eye = normalize(eye.xyz - c.p);
    FastPlace p = FastPlace(c.u, across_of(c, to_eye), 0.0, fibre_here(),
                            vec3(1.0), 1.0, fibre_d_b, fibre_d_f);
    p.theta_o = special_asin(clamp(dot(to_eye, c.u), -1.0, 1.0));
    float view = lit_view(p.theta_o);
    uint n = 0u;
#if defined(LIT_KEPT) && !defined(LIT_NEW)
    for (; n < lit_directs; n++) {
        uint at_n = n * lit_places + lit_at_record;
        LitDirect l = lit_direct_of(texelFetch(lit_direct, int(at_n)).xy);
#else
    vec4 through = vec4(0.0);
    for (uint k = 0u; k < light_count; k++) {
        uvec4 m = lit_member[k];
        vec4 g = nodes_of(m.x, c, at);
        uvec2 direct =
            lit_direct_record(fast_light(p, lights[m.x].place), m.x, g);
        LitDirect l = lit_direct_of(direct);
#ifdef LIT_NEW
        if (l.clear >= LIT_LEAST)
            directs[n * lit_places + lit_at_record] = direct;
        n += l.clear >= LIT_LEAST ? 1u : 0u;
#ifdef WITH_MULTIPLE
        through += uintBitsToFloat(m.y) * g;
        if (m.z != 0u) {
            uint group = m.z - 1u;
            records[group * lit_places + lit_at_record] =
                lit_record(p, lit_axis[group], through);
            through = vec4(0.0);
        }
#endif
#endif
        if (l.clear < LIT_LEAST)
            continue;
#endif
        mark_at(l, p.theta_o, view);
    }
#ifdef LIT_NEW
    order[lit_at_record].y = n;
#endif
}
