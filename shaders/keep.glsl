// keep.glsl - coverage below one (a strand thinner than a pixel, an opacity) is
// a decision per strand and sample, drawn from an Owen-scrambled radical
// inverse: over N = 2^k samples every strand is kept in its share of them to
// within one, and no two strands are in step.

uint keep_mix(uint x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// Nested uniform scramble of reversed bits (Laine and Karras 2011).
uint keep_scramble(uint x, uint seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ x * 0x8d22f6e6u;
}

// In [0, 1): the strand is kept where its share is larger.
float keep_draw(uint strand, uint index)
{
    uint seed = keep_mix(strand + 0x9e3779b9u);
    uint u = bitfieldReverse(keep_scramble(index, seed));
    return float(u >> 8) * (1.0 / 16777216.0);
}
