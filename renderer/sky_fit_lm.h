// sky_fit_lm.h - moves and widens the lobes of a started model.
// Thread: any; values only.
#ifndef RENDERER_SKY_FIT_LM_H
#define RENDERER_SKY_FIT_LM_H

#include "renderer/sky_fit_model.h"

// Returns the iterations done, at most 40; ends earlier when the residual is
// below 0.001 or falls no more.  m->f2 does not rise.
// watch: NULL, or ends it early.
int sky_fit_lm_run(struct sky_fit_model *m, struct watch *watch);

#endif
