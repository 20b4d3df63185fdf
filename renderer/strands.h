// strands.h - a groom in GPU memory, in world units and axes.
//
// Buffers, one element a point: positions vec4 (x, y, z, diameter; the
// diameter is negative at a strand's last point, so a segment i joins points i
// and i + 1 unless w_i < 0), the strand's index, and only when wanted opacity,
// colour and the cross section's major axis.
// Thread: render.
#ifndef RENDERER_STRANDS_H
#define RENDERER_STRANDS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/params.h"
#include "renderer/camera.h"
#include "renderer/groom.h"
#include "renderer/watch.h"

struct strands { // zero-initialised is empty
    unsigned position, strand, opacity, colour, axis; // buffers, 0 = not there
    unsigned bounds;         // buffer: each group's box, middle and half sides
    unsigned points_texture; // position as a texture buffer; 0: too many
    uint32_t points, strands, groups;
    float diameter; // in use, file units (the largest where it varies)
    float diameter_min, diameter_max; // world
    float plain_colour[4];            // rgb and opacity where there is no array
    bool draw_thin, draw_wide;        // set by strands_widths
    float thin_most; // largest share of samples that keep a thin strand
    int up;          // axis taken as up
    float box_min[3], box_max[3]; // world, the head included
    bool has_head;
    float head_centre[3], head_radius[3]; // world
    uint64_t bytes;
    struct watch *watch; // NULL, or cuts what is built, which then is false
};

// Neighbouring segments, of which a raster wants to know at once whether any of
// them can be seen: group g has the segments that begin at its points.
enum { STRANDS_GROUP = 8 };

// Uploads what `p`'s group hair asks for.
bool strands_build(struct strands *s, const struct groom *g,
                   const struct params *p, struct error *err);
// The major axis v of every point (snorm16 octahedral): a rotation-minimising
// frame (double reflection), turned at the root by a seeded angle a strand.
// Done only when an eccentric fibre asks for it.
bool strands_build_axis(struct strands *s, const struct groom *g,
                        struct error *err);
// The same without a GPU: axis[points].  Thread: any.
void strands_axes(const struct groom *g, int up, uint32_t *axis);
// Which of the two rasters a camera needs: some segment may be thinner or wider
// than the threshold in pixels.  scale: pixels per (diameter / depth).
void strands_widths(struct strands *s, const struct camera *c, float scale);
void strands_finish(struct strands *s);

#endif
