// lights.glsl - the SRBF lights that matter, in the world.
struct Light {
    vec4 place;    // xyz centre (unit), w = lambda
    vec4 radiance; // rgb L_j with colour and exposure; w = solid angle
};
layout(std140, binding = 2) uniform Lights {
    Light lights[200];
    uint light_count;
};
