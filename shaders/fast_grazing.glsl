// fast_grazing.glsl - R seen along the fibre, where the tables of fast.glsl do
// not hold: Fresnel's reflection and 1/cos^2 theta_d bend within a cell, and
// theta_i ends at +-pi/2 in the midst of the lobe.  Integrated as the direct
// path does.  Include after fast.glsl and best.glsl.

// |theta_o| from which R is integrated: below, the sum of modes over a sky errs
// by 2.5 % at most, beyond it would by up to 40 % (docs/METHODS.md, 1.6).
const float FAST_GRAZING = 1.2;

bool fast_grazes(float theta_o) { return abs(theta_o) > FAST_GRAZING; }

// M_R of eq 11; across as in fast_modes.
vec3 fast_grazing_r(Fibre f, Srbf light, float theta_o, float across)
{
    BestFibre b;
    b.index = vec4(f.eta * f.eta - 1.0, 2.0 * f.eta, f.eta, 0.0);
    BestLight l = best_light(Srbf(light.theta, 0.0, light.lambda),
                             XU_PI * across);
    return vec3(best_sum_r(best_rule(f.beta.x, f.alpha.x, light, theta_o),
                           theta_o, b, l));
}
