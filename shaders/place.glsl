// place.glsl - where on the hair something is; a cell's: its key undone.
#include "special.glsl"

struct Place {
    uint key, segment;
    float along; // 0..1 on the segment
    vec3 p;      // world
    vec3 u;      // unit tangent, root to tip
};

Place place_at(uint segment, float along)
{
    Place c;
    c.key = 0u;
    c.segment = segment;
    c.along = along;
    vec3 a = points[segment].xyz, b = points[segment + 1u].xyz;
    c.p = mix(a, b, along);
    vec3 sum = mix(tangent_at(segment), tangent_at(segment + 1u), along);
    float n = dot(sum, sum);
    c.u = n > 1e-12 ? sum * inversesqrt(n) : tangent_at(segment);
    return c;
}

// The middle of a cell.
Place place_of_key(uint key)
{
    uint segment = key >> CELL_BITS;
    float cell = float(key & (CELLS_MAX - 1u)) + 0.5;
    Place c = place_at(segment, cell / float(cell_count(segment)));
    c.key = key;
    return c;
}

// Of a cell as it is listed.
Place place_of(uint entry)
{
    return place_of_key(entry - 1u);
}
