// cells.glsl - the store of shaded cells: a hash table from (segment, cell) to
// radiance.  A cell's radiance depends on its key alone, so it does not matter
// which thread finds a place first.
// What is kept of a cell is kept by its number, the order in which cells were
// found: neighbours in the picture are neighbours there.
layout(std430, binding = 4) buffer Keys { uint keys[]; };      // by slot; 0 = free
layout(std430, binding = 5) buffer Radiance { vec4 radiance[]; }; // by number
layout(std430, binding = 6) buffer List { uint list[]; };      // keys, by number
layout(std430, binding = 7) buffer Counts {
    uint listed;         // entries of list[]
    uint lost;           // pixels that found no slot: must stay 0
    uint pad0;
    uint shaded;         // cells that one sample shades
    uvec4 dispatch;      // the groups for them; w: where they begin in list[]
    uint list_end[];     // per kept sample: entries of list[] after it
};
layout(std430, binding = 8) buffer Map { uint map[]; };        // per pixel
// map: 0 nothing, 1 head, MAP_FIRST + number
const uint MAP_FIRST = 2u;
