// nodes.glsl - the kept transmittances: [light][place], packed as shadow.glsl
// does it.
layout(std430, binding = 15) buffer Nodes { uvec2 nodes[]; };
layout(location = 2) uniform uint nodes_stride; // places of this dispatch
layout(location = 4) uniform uint nodes_begin;  // the first, of the sample's
