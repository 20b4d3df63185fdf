// nodes.glsl - the kept transmittances: [light][place], packed as shadow.glsl
// does it.  Who shades reads them as texels, which costs a CPU renderer a third
// of a load from a storage buffer.
#ifdef NODES_WRITTEN
layout(std430, binding = 15) buffer Nodes { uvec2 nodes[]; };
#else
layout(binding = 17) uniform usamplerBuffer nodes;
#endif
layout(location = 2) uniform uint nodes_stride; // places of this dispatch
layout(location = 4) uniform uint nodes_begin;  // the first, of the sample's
