// shadow_map.glsl - optical depth maps, the comparison to the crossings' field:
// what shadow_nodes of shadow.glsl is made of where shadow.method is map.
//
// A map looks at the hair along its light's centre (orthographic) and holds, in
// layers of equal depth, the fibres crossed in each as a summed-area table.  A
// lobe's mean of them is a box as wide as the lobe has become at the layer's
// distance: a kernel that depends on depth (Ren 2010, as Xu 2011, section 3
// describes it).
layout(binding = 9) uniform sampler2DArray shadow_maps; // light * layers + layer
layout(std140, binding = 7) uniform ShadowMaps {
    vec4 shadow_map_size; // cells along a side; 1 / (cells + 1); start, cells;
                          // layers
    vec4 shadow_frame[4u * SHADOW_LIGHTS]; // rows of world -> cells, cells,
                                           // layers; cells a layer of lobe
};

float shadow_summed(vec2 at, float slice)
{
    return textureLod(shadow_maps,
                      vec3((at + 0.5) * shadow_map_size.y, slice), 0.0).r;
}

// Fibres crossed from p towards light j, the mean over a box of half width
// spread (cells for each layer of distance) but at least `least` (cells).
float shadow_map_crossings(uint j, vec3 p, vec2 spread, float least)
{
    vec4 q = vec4(p, 1.0);
    vec3 at = vec3(dot(shadow_frame[4u * j], q), dot(shadow_frame[4u * j + 1u], q),
                   dot(shadow_frame[4u * j + 2u], q));
    float cells = shadow_map_size.x, n = 0.0;
    int layers = int(shadow_map_size.w);
    at.z = max(at.z + shadow_map_size.z * shadow_frame[4u * j + 3u].z, 0.0);
    for (int l = int(at.z); l < layers; l++) {
        float share = min(float(l + 1) - at.z, 1.0);
        float away = float(l + 1) - 0.5 * share - at.z;
        vec2 wide = max(spread * away, vec2(least));
        vec2 low = clamp(at.xy - wide, vec2(0.0), vec2(cells));
        vec2 high = clamp(at.xy + wide, vec2(0.0), vec2(cells));
        float slice = float(int(j) * layers + l);
        float sum = shadow_summed(high, slice) + shadow_summed(low, slice) -
                    shadow_summed(vec2(low.x, high.y), slice) -
                    shadow_summed(vec2(high.x, low.y), slice);
        n += share * max(sum, 0.0) / (4.0 * wide.x * wide.y);
    }
    return n;
}

// T~ by the kernel of the lobe, exp of the mean; T_f along the light's centre
// from the sparse samples.
vec4 shadow_mapped(uint j, vec3 p, ShadowPlace s)
{
    uvec4 l = shadow_light[j];
    float n = shadow_map_crossings(j, p, shadow_frame[4u * j + 3u].xy, 0.5);
    uint slot = uint(shadow_way[l.x].w);
    vec4 h = shadow_slot[slot];
    float open = shadow_past_head(s, h.xyz, h.w);
    float q = shadow_read(shadow_corner(s.g), slot);
    vec4 forward = shadow_powers(q);
    forward.x = exp(-n);
    forward.yz = max(forward.yz, forward.x);
    return open * forward;
}
