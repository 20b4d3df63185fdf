// shade_fast.glsl - shade.glsl's sum over lights, where tables light a place.
#include "fast.glsl"
#include "fast_near.glsl"
#ifdef WITH_SINGLE
#include "fast_grazing.glsl"
#endif

struct FastPlace {
    vec3 u, v; // along the fibre, across it towards the viewer: phi_o = 0
    float theta_o;
    Fibre fibre;
    vec3 shown;                  // of R, TT, TRT
    float global, glow, forward; // share.x, that of S_back, d_f
};

struct FastLight {
    Srbf lobe; // phi is not used
    float cos_j, cos_phi, across;
};

FastLight fast_light(FastPlace p, vec4 place)
{
    FastLight l;
    float along = clamp(dot(place.xyz, p.u), -1.0, 1.0);
    l.cos_j = sqrt(max(1.0 - along * along, 1e-12));
    l.lobe = Srbf(special_asin(along), 0.0, place.w);
    l.cos_phi = clamp(dot(place.xyz, p.v) / l.cos_j, -1.0, 1.0);
    l.across = 0.5 - special_asin(l.cos_phi) * (1.0 / XU_PI);
    return l;
}

#ifdef WITH_MULTIPLE
// As scattered() of shade.glsl.
vec3 fast_scattered(FastPlace p, FastLight l, vec4 g, float omega, DualView view)
{
    vec3 a_f, betabar2_f;
    fast_forward(l.lobe.theta, a_f, betabar2_f);
    ShadowLaw law = shadow_law(g);
    vec3 through = shadow_forward(law, a_f);
    vec3 crossed = shadow_crossings(law, a_f);
    vec3 sigma2 = l.lobe.lambda * l.lobe.lambda + 8.0 * betabar2_f * crossed;
    vec3 global = fast_global(p.fibre, p.theta_o, l.lobe.theta, l.across, sigma2);
    vec3 local = dual_back(view, l.lobe.theta, sigma2) *
                 ((1.0 - l.across) * (1.0 / XU_PI)); // eq 30
    vec3 near = fast_near(view, l.lobe, l.cos_phi);
    float clear = shadow_clear(g);
    vec3 forward = p.forward * omega * max(through - clear, 0.0);
    return clear * p.glow * near + forward * (p.global * global + p.glow * local);
}
#endif

#ifdef WITH_SINGLE
// R of a place that is seen along the fibre.  A loop of its own: a renderer on
// a CPU would run both sides of a branch in the other, while a loop without
// turns costs next to nothing.
vec3 fast_grazing(FastPlace p, Place c, uint at, uint first, uint end)
{
    vec3 sum = vec3(0.0);
    for (uint j = first; j < end; j++) {
        FastLight l = fast_light(p, lights[j].place);
        sum += lights[j].radiance.rgb * shadow_clear(nodes_of(j, c, at)) *
               fast_grazing_r(p.fibre, l.lobe, p.theta_o, l.across);
    }
    return sum;
}
#endif

vec3 shade_fast(Place c, uint at, uint first, uint end)
{
    vec3 to_eye = normalize(eye.xyz - c.p);
    // a copy: a value of a block costs more than a multiplication in the loop
    FastPlace p = FastPlace(c.u, across_of(c, to_eye), 0.0, fibre_here(),
                            mask.xyz, share.x, share.y * fibre_d_b, fibre_d_f);
    p.theta_o = special_asin(clamp(dot(to_eye, c.u), -1.0, 1.0));
#ifdef WITH_MULTIPLE
    DualView view = dual_view(p.theta_o);
#endif
    vec3 sum = vec3(0.0);
#ifdef WITH_SINGLE
    bool grazes = fast_grazes(p.theta_o) && p.shown.x > 0.0;
    sum = fast_grazing(p, c, at, first, grazes ? end : first);
    p.shown.x = grazes ? 0.0 : p.shown.x;
#endif
    for (uint j = first; j < end; j++) {
        FastLight l = fast_light(p, lights[j].place);
        vec4 g = nodes_of(j, c, at);
        vec3 r, tt, trt, seen = vec3(0.0);
#ifdef WITH_SINGLE
        fast_modes(p.fibre, l.lobe, p.theta_o, l.across, r, tt, trt);
        seen = shadow_clear(g) * (p.shown.x * r + p.shown.y * tt + p.shown.z * trt);
#endif
#ifdef WITH_MULTIPLE
        seen += fast_scattered(p, l, g, lights[j].radiance.w, view);
#endif
        sum += lights[j].radiance.rgb * seen;
    }
    return sum * colour_at(c.segment, c.along);
}
