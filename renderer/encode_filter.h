// encode_filter.h - the filters of PNG (ISO/IEC 15948, clause 9): rows become
// differences from their neighbours, which deflate better.
// Thread: any (no shared state).
#ifndef RENDERER_ENCODE_FILTER_H
#define RENDERER_ENCODE_FILTER_H

#include <stddef.h>

// Writes for each row the number of its filter, 0..4, and the filtered bytes:
// height * (1 + width * step) in all.  step: bytes a pixel, 4 = RGBA, 3 = RGB.
// Each row gets the filter whose differences, taken as signed bytes, have the
// smallest sum of absolute values.
void encode_filter(unsigned char *out, const unsigned char *rgba, size_t width,
                   size_t height, size_t step);

#endif
