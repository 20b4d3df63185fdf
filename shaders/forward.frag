#version 450 core
// Forward shading (Xu 2011, section 5): the light of a few lights from the
// fragment that a pixel sees, added to that of the other passes by blending.
// Hidden fragments fail the depth test before they get here; of two at the same
// depth the one whose id the pixel has is shaded.
#include "shade.glsl"
#include "fragment.glsl"
layout(early_fragment_tests) in;
layout(location = 17) uniform uvec2 lights_here; // first, and one after the last

flat in uint segment;
layout(location = 0) out vec4 seen;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 id = texelFetch(ids, pixel, 0).xy;
    if (id.x != ID_FIRST + segment)
        discard;
    uint at = 0u;
#ifdef SHADOW_STORED
    uint row = uint(size.y) - 1u - uint(pixel.y);
    at = map[sample_index.w + row * uint(size.x) + uint(pixel.x)] - MAP_FIRST;
    at -= nodes_begin;
    if (at >= nodes_stride)
        discard; // kept for another part of the fragments
#endif
    vec3 light = shade_seen(place_of_id(id), at, lights_here.x, lights_here.y);
    seen = vec4(light, lights_here.x == 0u ? 1.0 : 0.0);
}
