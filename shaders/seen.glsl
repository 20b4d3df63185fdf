// seen.glsl - how many samples of a pixel saw hair (from bit 16 on) and the head:
// one word tells most passes all that they need.  Where no sample saw hair the
// pixel's sum is zero.
const uint SEEN_HAIR = 0x10000u, SEEN_HEAD = 1u;

uint seen_hair(uint s) { return s >> 16; }
uint seen_head(uint s) { return s & 0xffffu; }
