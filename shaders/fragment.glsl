// fragment.glsl - the place of the hair that a pixel sees, from what the raster
// wrote (visible.frag).  With CENTRES the middle of its cell: what direct
// shading would take.
layout(binding = 14) uniform usampler2D ids;

Place place_of_id(uvec2 id)
{
    uint segment = id.x - ID_FIRST;
    float along = uintBitsToFloat(id.y);
#if defined(CENTRES) || defined(SHADOW_RAYS)
    uint n = cell_count(segment);
    uint cell = min(uint(along * float(n)), n - 1u);
    uint key = segment << CELL_BITS | cell; // rays are spread by it
#endif
#ifdef CENTRES
    return place_of_key(key);
#else
    Place c = place_at(segment, along);
#ifdef SHADOW_RAYS
    c.key = key;
#endif
    return c;
#endif
}
