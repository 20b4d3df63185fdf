// place.glsl - where on the hair a cell is: its key undone.
#include "special.glsl"

struct Place {
    uint key, segment;
    float along; // 0..1 on the segment, the cell's middle
    vec3 p;      // world
    vec3 u;      // unit tangent, root to tip
};

Place place_of(uint slot)
{
    Place c;
    c.key = keys[slot] - 1u;
    c.segment = c.key >> CELL_BITS;
    float cell = float(c.key & (CELLS_MAX - 1u)) + 0.5;
    c.along = cell / float(cell_count(c.segment));
    vec3 a = points[c.segment].xyz, b = points[c.segment + 1u].xyz;
    c.p = mix(a, b, c.along);
    vec3 sum = mix(tangent_at(c.segment), tangent_at(c.segment + 1u), c.along);
    float n = dot(sum, sum);
    c.u = n > 1e-12 ? sum * inversesqrt(n) : tangent_at(c.segment);
    return c;
}
