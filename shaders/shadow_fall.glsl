// shadow_fall.glsl - how crossings n are kept: exp(-SHADOW_FALL n) in a byte,
// which tells apart up to 27 of them and half a hundredth of none.
// SHADOW_ROOT gives exp(-n / 20), of which every node is a whole power.
const float SHADOW_FALL = 0.2;
#define SHADOW_ROOT(q) sqrt(sqrt(q))
