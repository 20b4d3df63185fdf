#version 450 core
// Reads a texture through each of a driver's first samplers, for program_use.
layout(local_size_x = 1) in;
layout(binding = 40) uniform sampler2D any[16];
layout(std430, binding = 11) writeonly buffer Nothing { float nothing[]; };

void main()
{
    float s = 0.0;
    for (int i = 0; i < 16; i++)
        s += textureLod(any[i], vec2(0.5), 0.0).x;
    if (s > 1e30) // never: the texture is zero
        nothing[0] = s;
}
