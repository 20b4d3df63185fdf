#version 450 core
// The head hides what is behind it; how it looks is decided at display.
layout(location = 0) out uvec2 id;

void main()
{
    id = uvec2(1u, 0u); // ID_HEAD
}
