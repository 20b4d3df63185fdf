// lit_record.glsl - what a light and a place are to each other, whatever the
// fibre: where it stands and what of it arrives, in 16 bytes.  Made once a view
// for the places of a first sample (lit_mark.comp), else on the spot: what is
// read has been through the same 16 bits either way.  Include after
// shade_fast.glsl and lit.glsl.
#ifdef LIT_KEPT
layout(binding = 24) uniform usamplerBuffer lit_records; // [group][place]
// Of lights that reach a place directly: [n][place], n as many as there are.
layout(binding = 26) uniform usamplerBuffer lit_direct;
// Records' places, by which neighbours read the same cells (lit_order.comp), and
// how many lights reach each directly.
layout(binding = 25) uniform usamplerBuffer lit_order;
uint lit_at_record, lit_directs;         // of this invocation
layout(location = 6) uniform uint lit_places; // of a light or group

uint lit_unsorted(uint at)
{
    uvec2 order = texelFetch(lit_order, int(at)).xy;
    lit_at_record = at;
    lit_directs = order.y;
    return order.x;
}
#endif

// As light that meets no fibre needs it.
struct LitDirect {
    float theta_j, across; // |Phi| / pi
    float clear;           // T~
    uint light;
};

uvec2 lit_direct_record(FastLight l, uint light, vec4 g)
{
    return uvec2(packUnorm2x16(vec2(l.lobe.theta * (1.0 / LIT_PI) + 0.5, l.across)),
                 packUnorm2x16(vec2(shadow_clear(g), 0.0)) | light << 16);
}

LitDirect lit_direct_of(uvec2 r)
{
    vec2 at = unpackUnorm2x16(r.x);
    return LitDirect((at.x - 0.5) * LIT_PI, at.y, unpackUnorm2x16(r.y).x,
                     r.y >> 16);
}

struct LitPair {
    float theta_j, across; // |Phi| / pi
    float clear;           // T~
    vec3 fall;             // -ln of G / G(0) at the nodes of shadow.glsl
    float open;            // G(0)
};
const float LIT_FALL = 12.0; // the most that a node can have fallen

uvec4 lit_record(FastPlace p, vec4 place, vec4 g)
{
    FastLight l = fast_light(p, place);
    uvec4 r;
    r.x = packUnorm2x16(vec2(l.lobe.theta * (1.0 / LIT_PI) + 0.5, l.across));
    r.yz = uvec2(0u);
    r.w = floatBitsToUint(shadow_clear(g));
#ifdef WITH_MULTIPLE
    vec3 fall = shadow_fall_of(g) * (1.0 / LIT_FALL);
    r.y = packUnorm2x16(fall.xy);
    r.z = packUnorm2x16(vec2(fall.z, g.w));
#endif
    return r;
}

LitPair lit_pair(uvec4 r)
{
    vec2 at = unpackUnorm2x16(r.x), a = unpackUnorm2x16(r.y);
    vec2 b = unpackUnorm2x16(r.z);
    return LitPair((at.x - 0.5) * LIT_PI, at.y, uintBitsToFloat(r.w),
                   vec3(a, b.x) * LIT_FALL, b.y);
}

// The nodes of a group whose first member is number k, which becomes the next
// one's: the mean of its lights' by power.
vec4 lit_through(inout uint k, Place c, uint at)
{
    vec4 sum = vec4(0.0);
    for (bool more = true; more; k++) {
        uvec4 m = lit_member[k];
        sum += uintBitsToFloat(m.y) * nodes_of(m.x, c, at);
        more = m.z == 0u;
    }
    return sum;
}
