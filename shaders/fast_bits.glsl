// fast_bits.glsl - how numbers are packed into cells (fast.glsl unpacks them).
// Include after fast_size.glsl.
uint fast_bf16(float x)
{
    uint bits = floatBitsToUint(x);
    return (bits + 0x7fffu + (bits >> 16 & 1u)) >> 16;
}

uint fast_two(float high, float low)
{
    return fast_bf16(high) << 16 | fast_bf16(low);
}

uint fast_byte_of(float x)
{
    return uint(int(round(clamp(x, -2.0, 2.0) * (1.0 / FAST_BYTE)))) & 255u;
}
