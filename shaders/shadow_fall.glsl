// shadow_fall.glsl - how crossings n are kept: exp(-SHADOW_FALL n) in a byte,
// which tells apart up to 27 of them and half a hundredth of none.
const float SHADOW_FALL = 0.2;
