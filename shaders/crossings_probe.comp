#version 450 core
// Nodes for arrays of points and lights, and what is read from them, by the
// very functions of a picture.
#include "shadow.glsl"
layout(local_size_x = 64) in;
layout(location = 0) uniform uvec2 count; // points, lights
layout(location = 1) uniform vec4 attenuation;
layout(location = 2) uniform uint rays;
struct Place { vec3 p; uint segment; vec3 u; uint key; };
struct Result { uvec2 nodes; float clear; uint guards; vec4 forward, crossings; };
layout(std430, binding = 2) readonly buffer Places { Place places[]; };
layout(std430, binding = 3) writeonly buffer Results { Result results[]; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count.x)
        return;
    Place at = places[i];
    // A light an invocation, not a loop over lights: some drivers end loops
    // that take more than 65535 turns in all, rays are many.
    uint j = gl_WorkGroupID.y;
    Result r;
#ifdef GIVEN_NODES // to read from: bits instead of a place
    r.nodes = uvec2(floatBitsToUint(at.p.x), floatBitsToUint(at.p.y));
#elif defined SHADOW_RAYS
    r.nodes = shadow_nodes_rays(j, at.p, at.u, at.segment, at.key, rays);
#else
    r.nodes = shadow_nodes(j, at.p, at.u, at.segment, at.key);
#endif
    vec4 g = shadow_unpack(r.nodes);
    ShadowLaw law = shadow_law(g);
    r.clear = shadow_clear(g);
    r.guards = 0u;
    r.forward = vec4(shadow_forward(law, attenuation.xyz),
                     shadow_forward(law, attenuation.www).x);
    r.crossings = vec4(shadow_crossings(law, attenuation.xyz),
                       shadow_crossings(law, attenuation.www).x);
#ifdef GUARDS
    r.guards = guard_bits[2];
#endif
    results[i * count.y + j] = r;
}
