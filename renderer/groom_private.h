// groom_private.h - what the files of the groom room share.
// Thread: any (no shared state).
#ifndef RENDERER_GROOM_PRIVATE_H
#define RENDERER_GROOM_PRIVATE_H

#include "renderer/groom.h"

#define GROOM_MAX_POINTS 8000000u
#define GROOM_MAX_BYTES (512u << 20)

// A groom with room for these counts: first[], position[] allocated and not
// yet set, the other arrays NULL, the defaults those of a file that says
// nothing.  The counts were checked by the caller.
struct groom *groom_private_new(const char *name, uint32_t strands,
                                uint32_t points);

// Fills box_min and box_max and, when `find_up` is set, `up`, from first[] and
// position[].
void groom_private_measure(struct groom *g, bool find_up);

#endif
