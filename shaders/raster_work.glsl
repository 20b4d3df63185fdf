// raster_work.glsl - what the passes of the raster hand on to each other.
layout(std430, binding = 13) buffer Depths { uint depth_seen[]; }; // near / w
layout(std430, binding = 14) buffer Seen { uint seen_id[]; };
// Lists, two of a kind, for lines (0) and for ribbons (1): groups of segments
// that may be seen, windows of long segments, and what was nearest somewhere
// when it was met.  Then one of the pixels that see a segment.
layout(std430, binding = 3) buffer Work {
    uvec4 work[7]; // groups of 64 along x, y, z for a list's entries; entries
    uint entry[];
};
const uint RASTER_GROUP = 8u; // segments, RASTER_GROUP of raster.h
const uint GROUPS = 0u, WINDOWS = 2u, NEAREST = 4u; // + line or ribbon
const uint PIXELS = 6u;
const uint RASTER_ROW = 64u; // groups along x
layout(location = 0) uniform uvec3 raster_room; // entries of a list of a kind

// Where the n-th entry of a list stands.  A segment is a line or a ribbon, so
// of what was nearest one list grows from the front, the other from the back.
uint entry_of(uint list, uint n)
{
    uint which = list & 1u;
    if (list < WINDOWS)
        return which * raster_room.x + n;
    if (list < NEAREST)
        return 2u * raster_room.x + which * raster_room.y + n;
    uint from = 2u * (raster_room.x + raster_room.y);
    if (list == PIXELS)
        return from + raster_room.z + n;
    return which == 0u ? from + n : from + raster_room.z - 1u - n;
}

// a: threads that an entry takes.
bool list_entry(uint list, uint value, uint a)
{
    uint n = atomicAdd(work[list].w, 1u);
    if (list >= WINDOWS && list < NEAREST && n >= raster_room.y)
        return false;
    entry[entry_of(list, n)] = value;
    if (n * a % (64u * RASTER_ROW) == 0u)
        atomicAdd(work[list].y, 1u);
    return true;
}
