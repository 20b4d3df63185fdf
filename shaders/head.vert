#version 450 core
// The head: an ellipsoid of 96 x 48 quads, made from the vertex number.  Its
// flat faces lie inside the true ellipsoid by less than .06 % of its radius.
#include "scene.glsl"

const uint ROUND = 96u, RISE = 48u;

void main()
{
    uint quad = uint(gl_VertexID) / 6u, corner = uint(gl_VertexID) % 6u;
    uint right_side = (0x1Au >> corner) & 1u; // corners 1, 3, 4
    uint top_side = (0x34u >> corner) & 1u;   // corners 2, 4, 5
    float a = 6.28318531 * float(quad % ROUND + right_side) / float(ROUND);
    float b = 3.14159265 * float(quad / ROUND + top_side) / float(RISE);
    vec3 n = vec3(sin(b) * cos(a), sin(b) * sin(a), cos(b));
    vec4 c = clip_of(head_centre.xyz + head_radius.xyz * n);
    c.xy += jitter.xy * c.w;
    gl_Position = c;
}
