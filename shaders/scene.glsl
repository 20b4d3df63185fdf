// scene.glsl - what every pass of a picture shares: camera, strands, and the
// names of the pixels' contents.
#include "params.glsl"

layout(std140, binding = 1) uniform Scene {
    mat4 view_proj;     // unjittered
    vec4 eye;           // xyz
    vec4 size;          // width, height in pixels; pixels per radian-tangent; near
    vec4 jitter;        // of this sample, in clip units: x, y; z: the largest
                        // share of samples in which a thin strand is kept
    vec4 right;         // camera axes scaled to the picture's edge
    vec4 up;
    vec4 forward;
    vec4 head_centre;   // xyz; w = 1 where there is a head
    vec4 head_radius;   // xyz
    vec4 hair_colour;   // rgb of a file without a colour a point; w = opacity
    mat4 sky_to_map;    // world direction -> map direction
    uvec4 sample_index; // x: this sample; y: points; z: hash slots - 1; w: map
    vec4 mask;          // which of R, TT, TRT are shown
    vec4 share;         // x global, y local multiple scattering: shown or not
};

layout(std430, binding = 0) readonly buffer Points { vec4 points[]; };
layout(std430, binding = 1) readonly buffer Strands { uint strand_of[]; };

const uint ID_NONE = 0u, ID_HEAD = 1u, ID_FIRST = 2u; // ID_FIRST + segment
// A segment is cut into at most 512 cells of about a pixel; a cell is what is
// shaded once and then shared by all samples that see it.
const uint CELL_BITS = 9u, CELLS_MAX = 512u;

vec4 clip_of(vec3 p)
{
    precise vec4 c = view_proj[0] * p.x + view_proj[1] * p.y +
                     view_proj[2] * p.z + view_proj[3];
    return c;
}

vec2 pixel_of(vec4 clip)
{
    precise vec2 p = 0.5 * clip.xy / max(clip.w, size.w) * size.xy;
    return p;
}

// Cells of the segment between two points, from the unjittered camera, so that
// every sample finds the same.
uint cells_between(vec4 clip_a, vec4 clip_b)
{
    precise vec2 d = pixel_of(clip_b) - pixel_of(clip_a);
    precise float n = sqrt(d.x * d.x + d.y * d.y);
    return clamp(uint(ceil(min(n, 512.0))), 1u, CELLS_MAX);
}

uint cell_count(uint i)
{
    return cells_between(clip_of(points[i].xyz), clip_of(points[i + 1u].xyz));
}

// Tangent at point i, central difference within its strand.
vec3 tangent_at(uint i)
{
    uint a = i > 0u && points[i - 1u].w > 0.0 ? i - 1u : i;
    uint b = points[i].w > 0.0 ? i + 1u : i;
    vec3 d = points[b].xyz - points[a].xyz;
    float n = dot(d, d);
    return n > 0.0 ? d * inversesqrt(n) : vec3(0.0, 0.0, -1.0);
}

// A pixel's place in the sample's map of cells.  Rows are bottom first in the
// raster, top first in everything after.
uint map_place(uvec2 pixel)
{
    uint row = uint(size.y) - 1u - pixel.y;
    return sample_index.w + row * uint(size.x) + pixel.x;
}
