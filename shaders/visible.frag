#version 450 core
// Which segment a pixel sees, and where on it.  Coverage below one (a strand
// thinner than a pixel, an opacity) is a decision per strand and sample, drawn
// from an Owen-scrambled radical inverse: over N = 2^k samples every strand is
// kept in its share of them to within one, and no two strands are in step.
#include "scene.glsl"

in float along;
in float keep;
flat in uint segment;
layout(location = 0) out uvec2 id;

uint mix_bits(uint x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// Nested uniform scramble of reversed bits (Laine and Karras 2011).
uint scramble(uint x, uint seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ x * 0x8d22f6e6u;
}

void main()
{
    uint seed = mix_bits(strand_of[segment] + 0x9e3779b9u);
    uint u = bitfieldReverse(scramble(sample_index.x, seed));
    if (float(u >> 8) * (1.0 / 16777216.0) >= keep)
        discard;
    id = uvec2(ID_FIRST + segment, floatBitsToUint(clamp(along, 0.0, 1.0)));
}
