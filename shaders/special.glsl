// special.glsl - special functions in single precision, for arguments that no
// legal parameter can drive into an overflow or a NaN.
#include "guard.glsl"

// erfc(|t|), given e = exp(-t^2).  Abramowitz & Stegun 7.1.26; absolute error
// 1.5e-7.
vec2 special_erfc(vec2 t, vec2 e)
{
    vec2 k = 1.0 / (1.0 + 0.3275911 * abs(t));
    vec2 p = -1.453152027 + 1.061405429 * k;
    p = 1.421413741 + p * k;
    p = -0.284496736 + p * k;
    p = 0.254829592 + p * k;
    return p * k * e;
}

// The modified Bessel function I_0 of x >= 0 times exp(-x), its exponential
// apart: the result is value * exp(-rest), so that it can be joined with
// another.  Two polynomials that meet at 4.5, made here by Chebyshev
// interpolation; relative error 8e-7.
vec3 special_i0(vec3 x, out vec3 rest)
{
    vec3 z = min(x * x * (2.0 / 20.25) - 1.0, 1.0);
    vec3 low = 0.010936114 + 0.000725538646 * z;
    low = 0.115956546 + low * z;
    low = 0.81885275 + low * z;
    low = 3.46131635 + low * z;
    low = 7.4107965 + low * z;
    low = 5.66258748 + low * z;
    vec3 r = inversesqrt(max(x, 4.5)), y = 9.0 * r * r - 1.0;
    vec3 high = 0.000115092952 + 3.05433091e-05 * y;
    high = 0.000540871668 + high * y;
    high = 0.00639212006 + high * y;
    high = 0.404878338 + high * y;
    bvec3 small = lessThan(x, vec3(4.5));
    rest = mix(vec3(0.0), x, small);
    return mix(high * r, low, small);
}

float special_i0e(float x)
{
    vec3 rest, v = special_i0(vec3(x), rest);
    return v.x * exp(-rest.x);
}

// atan on [0, 1]; relative error 7e-7.
float special_atan01(float x)
{
    float z = 2.0 * x * x - 1.0;
    float p = -0.000419443138 + 0.000122273171 * z;
    p = 0.00130253403 + p * z;
    p = -0.00500047609 + p * z;
    p = 0.020854519 + p * z;
    p = -0.101880416 + p * z;
    p = 0.870419667 + p * z;
    return x * p;
}

// cos on [-pi/2, pi/2], never negative, zero at both ends; absolute error 1e-7.
float special_cos(float x)
{
    float u = min(x * x, 2.4674011);
    float p = -5.94830079e-05 + 6.36755509e-07 * u;
    p = 0.00327995779 + p * u;
    p = -0.0947152477 + p * u;
    p = 0.999999999 + p * u;
    return max(1.0 - u * 0.405284735, 0.0) * p;
}

vec4 special_cos(vec4 x)
{
    vec4 u = min(x * x, 2.4674011);
    vec4 p = -5.94830079e-05 + 6.36755509e-07 * u;
    p = 0.00327995779 + p * u;
    p = -0.0947152477 + p * u;
    p = 0.999999999 + p * u;
    return max(1.0 - u * 0.405284735, 0.0) * p;
}

// sin on [-pi/2, pi/2]; relative error 5e-9 and rounding.
float special_sin(float x)
{
    float u = x * x;
    float p = -0.000198090174 + 2.60510763e-06 * u;
    p = 0.00833305017 + p * u;
    p = -0.166666579 + p * u;
    return x + x * (u * p);
}

vec4 special_sin(vec4 x)
{
    vec4 u = x * x;
    vec4 p = -0.000198090174 + 2.60510763e-06 * u;
    p = 0.00833305017 + p * u;
    p = -0.166666579 + p * u;
    return x + x * (u * p);
}

// Integral over a period of the product of two circular Gaussians,
//   exp(k1 (cos x - 1)) exp(k2 (cos(d - x) - 1)),
// is 2 pi value exp(-less); cos2, sin2 are the squares of cos(d/2), sin(d/2).
// Written so that no two large numbers are subtracted but k1 - k2.
vec3 special_gauss_product(float k1, vec3 k2, vec3 cos2, vec3 sin2,
                           out vec3 less)
{
    vec3 four = 4.0 * k1 * k2, apart = k1 - k2, rest;
    vec3 k = sqrt(apart * apart + four * cos2);
    vec3 i0 = special_i0(k, rest);
    GUARD(GUARD_GAUSS_FLAT, lessThan(k + k1 + k2, vec3(1e-22)));
    less = rest + four * sin2 / (k + k1 + k2 + 1e-30);
    return i0;
}

// asin of x clamped to [-1, 1]; absolute error 2e-7, where a GLSL built-in may
// be off by 4e-4 (a tenth of a narrow lobe's width).
float special_asin(float x)
{
    float a = min(abs(x), 1.0);
    bool far = a > 0.5;
    float z = far ? 0.5 - 0.5 * a : a * a, s = far ? sqrt(z) : a;
    float p = 0.0397211348 + 0.050505363 * z;
    p = 0.0754647958 + p * z;
    p = 0.166651637 + p * z;
    p = s + s * (p * z);
    p = far ? 1.57079633 - 2.0 * p : p;
    return x < 0.0 ? -p : p;
}
