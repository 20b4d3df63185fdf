// sky_fit_start.h - where a fit begins: matching pursuit over fixed atoms.
// Thread: any; values only.
#ifndef RENDERER_SKY_FIT_START_H
#define RENDERER_SKY_FIT_START_H

#include "renderer/sky_fit_model.h"

// Fills an empty model with up to `lights` lobes, its amplitudes refitted.
// Fewer when nothing positive is left to pick.
// watch: NULL, or ends it early.
void sky_fit_start_run(struct sky_fit_model *m, int lights,
                       struct watch *watch);

#endif
