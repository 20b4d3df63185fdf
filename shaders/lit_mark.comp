#version 450 core
// Keeps what lights and places are to each other, and marks the cells of lights'
// tables that they read: those whose light is not blocked.
#include "shade.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uint kept;
layout(std430, binding = 13) writeonly buffer Marks { uint marks[]; };
layout(std430, binding = 14) writeonly buffer Records { uvec4 records[]; };

void mark(uvec4 light, vec3 place)
{
    LitAt a = lit_at(place, vec2(LIT_D, float(lit_phis(light))));
    marks[light.z + uint(a.cell)] = 1u;
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
    for (uint j = 0u; j < light_count; j++) {
        uvec4 table = lit_light[j];
#if defined(LIT_KEPT) && !defined(LIT_NEW)
        uvec4 r = texelFetch(lit_records, int(j * lit_places + lit_at_record));
#else
        uvec4 r = lit_record(p, lights[j].place, nodes_of(j, c, at));
#ifdef LIT_KEPT
        records[j * lit_places + lit_at_record] = r;
#endif
#endif
        LitPair l = lit_pair(r);
        if (table.y == 0u || l.clear < LIT_LEAST)
            continue;
        vec3 place = lit_place(table, p.theta_o + l.theta_j, view, l.across);
        mark(table, place + 1e-3);
        // Both sides of an edge: another program may round otherwise.
        if (any(greaterThan(abs(fract(place) - 0.5), vec3(0.499))))
            mark(table, place - 1e-3);
    }
}
