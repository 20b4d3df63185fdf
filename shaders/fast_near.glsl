// fast_near.glsl - light that no fibre blocked and the hair around turns back,
// nearly as dual_back_direct of dual.glsl.  Include after fast.glsl; with
// multiple scattering, after dual.glsl.
#ifdef WITH_MULTIPLE
struct FastNear {
    vec3 whole;   // without its share of the circle
    float k, i0e; // of the light's circular Gaussian
};

// What does not change with Phi: with the mean of cos theta_i and of what the
// circular Gaussian has more to second order and I_0 by a quotient (5e-3).
FastNear fast_near_of(DualView v, Srbf lobe)
{
    FastNear n;
    float light2 = lobe.lambda * lobe.lambda;
    float w2 = dot(v.width2, vec3(1.0 / 3.0)), part = light2 / (light2 + w2);
    float x = (dot(v.centre, vec3(1.0 / 3.0)) - lobe.theta) * part;
    float l2 = w2 * part, x2 = x * x;
    float cos_i = special_cos(clamp(lobe.theta + x, -XU_HALF_PI, XU_HALF_PI));
    float more = (x2 * (x2 + 3.0 * l2) + 0.75 * l2 * l2) / (12.0 * light2);
    float lit = cos_i * (1.0 + min(more, 1.0)) * (1.0 - 0.25 * l2);
    float k = 2.0 * cos_i * max(special_cos(lobe.theta), 1e-6) / light2;
    n.k = k;
    n.i0e = sqrt((1.0 + k * (0.50839 + 1.0023 * k)) /
                 (1.0 + k * (2.81076 + k * (1.57011 + 6.29764 * k))));
    n.whole = dual_back(v, lobe.theta, vec3(light2)) *
              (3.5449077 * lobe.lambda * lit * n.i0e);
    return n;
}

vec3 fast_near_at(FastNear n, float cos_phi)
{
    return n.whole * dual_half_share(n.k, n.i0e, cos_phi);
}

vec3 fast_near(DualView v, Srbf lobe, float cos_phi)
{
    return fast_near_at(fast_near_of(v, lobe), cos_phi);
}
#endif
