// shade_lit.glsl - shade.glsl's sum over lights, where each light has a table.
// Include after shade_fast.glsl.
#include "lit.glsl"
#include "lit_record.glsl"

#ifdef WITH_MULTIPLE
// As scattered() of shade.glsl, but for what meets no fibre.
vec3 lit_scattered(LitFar f, LitPair l, float s, float view, float lambda)
{
    vec3 a_f, betabar2_f;
    fast_forward(l.theta_j, a_f, betabar2_f);
    ShadowLaw law = shadow_law_of(l.fall, l.open, l.clear);
    vec3 through = shadow_forward(law, a_f);
    vec3 crossed = shadow_crossings(law, a_f);
    vec3 sigma2 = lambda * lambda + 8.0 * betabar2_f * crossed;
    return max(through - l.clear, 0.0) *
           lit_far_at(f, s, view, l.across, 0.5 * log(sigma2));
}
#endif

#ifdef LIT_REST
// Lights that have no table, narrow as they are.
vec3 lit_rest_of(FastPlace p, Place c, uint at)
{
    vec3 sum = vec3(0.0);
#ifdef WITH_MULTIPLE
    DualView view = dual_view(p.theta_o);
#endif
    bool grazes = fast_grazes(p.theta_o);
    for (uint i = 0u; i < lit_from.y; i++) {
        uint j = lit_rest[i / 4u][i % 4u];
        FastLight l = fast_light(p, lights[j].place);
        vec3 r, tt, trt;
        fast_modes(p.fibre, l.lobe, p.theta_o, l.across, r, tt, trt);
        if (grazes)
            r = fast_grazing_r(p.fibre, l.lobe, p.theta_o, l.across);
        vec3 seen = r + tt + trt;
#ifdef WITH_MULTIPLE
        seen += fibre_d_b * fast_near(view, l.lobe, l.cos_phi);
#endif
        sum += lights[j].radiance.rgb * seen * shadow_clear(nodes_of(j, c, at));
    }
    return sum;
}
#endif

// What reaches a place without meeting a fibre, of lights that have a table.
vec3 lit_reached(FastPlace p, Place c, uint at, float view)
{
    vec3 sum = vec3(0.0);
#ifdef LIT_KEPT
    uint record = lit_at_record;
    for (uint k = 0u; k < lit_directs; k++) {
        LitDirect l = lit_direct_of(texelFetch(lit_direct, int(record)).xy);
        record += lit_places;
#else
    for (uint k = 0u; k < light_count; k++) {
        uint j = lit_member[k].x;
        LitDirect l = lit_direct_of(lit_direct_record(
            fast_light(p, lights[j].place), j, nodes_of(j, c, at)));
        l.clear = l.clear >= LIT_LEAST ? l.clear : 0.0;
#endif
        uvec4 source = texelFetch(lit_source, int(l.light));
        vec3 seen = lit_near(lit_unpack(source.x), p.theta_o + l.theta_j, view,
                             l.across);
#ifdef LIT_REST
        l.clear = source.x != 0u ? l.clear : 0.0;
#endif
        sum += uintBitsToFloat(source.yzw) * (l.clear * seen);
    }
    return sum;
}

#ifdef WITH_MULTIPLE
// What other fibres scattered forward, a group of lights at a time.
vec3 lit_forward(FastPlace p, Place c, uint at, float view)
{
    LitFar far = lit_far_here();
    vec3 sum = vec3(0.0);
    int source = int(lit_light.length());
#ifdef LIT_KEPT
    uint record = lit_at_record;
    for (uint g = lit_groups.x; g > 0u; g--) {
        LitPair l = lit_pair(texelFetch(lit_records, int(record)));
        record += lit_places;
#else
    uint k = 0u;
    for (uint g = 0u; g < lit_groups.x; g++) {
        LitPair l = lit_pair(lit_record(p, lit_axis[g], lit_through(k, c, at)));
#endif
        uvec4 from = texelFetch(lit_source, source++);
        sum += uintBitsToFloat(from.yzw) *
               lit_scattered(far, l, p.theta_o + l.theta_j, view,
                             uintBitsToFloat(from.x));
    }
    return p.forward * sum;
}
#endif

vec3 shade_lit(Place c, uint at)
{
    vec3 to_eye = normalize(eye.xyz - c.p);
    FastPlace p = FastPlace(c.u, across_of(c, to_eye), 0.0, fibre_here(),
                            vec3(1.0), 1.0, fibre_d_b, fibre_d_f);
    p.theta_o = special_asin(clamp(dot(to_eye, c.u), -1.0, 1.0));
    float view = lit_view(p.theta_o);
#ifdef LIT_REST
    vec3 sum = lit_rest_of(p, c, at);
#else
    vec3 sum = vec3(0.0);
#endif
    return (sum + lit_reached(p, c, at, view)
#ifdef WITH_MULTIPLE
            + lit_forward(p, c, at, view)
#endif
            ) * colour_at(c.segment, c.along);
}
