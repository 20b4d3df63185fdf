// rehearsal.h - while the picture rests: the drafts that the next edit may ask
// for are made for nobody to see, so that the first draft of a drag finds its
// strands, its targets, its cells and its size, and takes no longer than those
// that follow.
// Thread: render.
#ifndef SERVER_REHEARSAL_H
#define SERVER_REHEARSAL_H

#include <stdbool.h>

#include "renderer/renderer.h"
#include "server/haste.h"

// What is to be known for a choice, but for `resting`.
void rehearsal_ask(const struct renderer *r, const struct params *p,
                   struct haste_ask *ask);
// Makes one of those that are not known yet (of hair, of lights, of the camera,
// of fibre and colours: whichever full frames are too slow for).  False where
// there is none, or none can be had.
bool rehearsal_next(struct haste *h, struct renderer *r,
                    const struct params *p);

#endif
