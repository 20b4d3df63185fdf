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

vec3 shade_lit(Place c, uint at, uint first, uint end)
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
#ifdef WITH_MULTIPLE
    LitFar far = lit_far_here();
#endif
#ifdef LIT_KEPT
    uint record = lit_at_record, apart = lit_places;
    record += first * apart;
#endif
    for (uint j = first; j < end; j++) {
        uvec4 table = lit_light[j];
#ifdef LIT_KEPT
        LitPair l = lit_pair(texelFetch(lit_records, int(record)));
        record += apart;
#else
        LitPair l = lit_pair(lit_record(p, lights[j].place, nodes_of(j, c, at)));
#endif
        float s = p.theta_o + l.theta_j;
        bool direct = l.clear >= LIT_LEAST;
#ifdef LIT_REST
        direct = direct && table.y > 0u;
#endif
        vec3 seen = direct ? l.clear * lit_near(table, s, view, l.across)
                           : vec3(0.0);
#ifdef WITH_MULTIPLE
        seen += (p.forward * lights[j].radiance.w) *
                lit_scattered(far, l, s, view, uintBitsToFloat(table.w));
#endif
        sum += lights[j].radiance.rgb * seen;
    }
    return sum * colour_at(c.segment, c.along);
}
