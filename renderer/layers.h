// layers.h - the parts of a picture beside the whole: each its own radiance of
// cells and its own sum, made sample by sample together with the whole, which
// so finds cells and transmittances for all of them once.
// Buffers are those of picture.h in size: 16 bytes a slot and 16 a pixel.
// Thread: render.
#ifndef RENDERER_LAYERS_H
#define RENDERER_LAYERS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/picture.h"

enum { LAYERS = 5 };

struct layers { // zero-initialised: off
    bool on;
    unsigned radiance[LAYERS], sum[LAYERS]; // 0: left out, black
    unsigned add;                           // program
    uint32_t slots;
    int width, height;
};

void layers_drop(struct layers *l); // off; buffers and program are freed

// Buffers of the picture's size for layer i; what they held is lost when it
// changed.
bool layers_fit(struct layers *l, int i, const struct picture *p,
                struct error *err);
// After picture_bind: layer i's in the place of the picture's own.
void layers_bind(const struct layers *l, int i);
void layers_add(const struct layers *l, const struct picture *p);
// As picture_read_sum; all zero when it was left out.
void layers_read(const struct layers *l, int i, const struct picture *p,
                 float *rgba, int samples);

#endif
