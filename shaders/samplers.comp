#version 450 core
// Reads a texture through each of a driver's first samplers, for program_use.
layout(local_size_x = 1) in;
layout(binding = 24) uniform sampler2D any[8];
layout(std430, binding = 11) writeonly buffer Nothing { float nothing[]; };

void main()
{
    vec2 at = vec2(0.5);
    float s = textureLod(any[0], at, 0.0).x + textureLod(any[1], at, 0.0).x +
              textureLod(any[2], at, 0.0).x + textureLod(any[3], at, 0.0).x +
              textureLod(any[4], at, 0.0).x + textureLod(any[5], at, 0.0).x +
              textureLod(any[6], at, 0.0).x + textureLod(any[7], at, 0.0).x;
    if (s > 1e30) // never: the texture is zero
        nothing[0] = s;
}
