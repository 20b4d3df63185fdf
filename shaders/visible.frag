#version 450 core
// Which segment a pixel sees (ID_FIRST of scene.glsl + segment), and where.
in float along;
in float keep;
flat in float drawn;
flat in uint segment;
layout(location = 0) out uvec2 id;

void main()
{
    if (drawn >= keep)
        discard;
    id = uvec2(2u + segment, floatBitsToUint(clamp(along, 0.0, 1.0)));
}
