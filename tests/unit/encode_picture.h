// encode_picture.h - pictures for the encoders' tests and bench: strands
// of hair drawn as soft lines, noise, ramps.  Same arguments, same pixels.
#ifndef TESTS_UNIT_ENCODE_PICTURE_H
#define TESTS_UNIT_ENCODE_PICTURE_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

static inline uint32_t picture_random(uint64_t *state) // xorshift64*
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (uint32_t)(*state * UINT64_C(0x2545f4914f6cdd1d) >> 32);
}

static inline float picture_uniform(uint64_t *state) // [0, 1)
{
    return (float)(picture_random(state) >> 8) / 16777216.0f;
}

static inline void picture_blend(float *pixel, const float colour[3], float a)
{
    for (int c = 0; c < 3; c++)
        pixel[c] += (colour[c] - pixel[c]) * a;
    pixel[3] += (1 - pixel[3]) * a;
}

// One strand: a quadratic curve, one pixel wide, with a highlight across.
static inline void picture_strand(float *rgba, int w, int h, uint64_t *random)
{
    float fw = (float)w, fh = (float)h, r[6];
    for (int i = 0; i < 6; i++)
        r[i] = picture_uniform(random);
    float spread = r[0] + r[1] - 1;
    float x0 = fw * (0.5f + 0.12f * spread), y0 = fh * (0.1f + 0.1f * r[2]);
    float x1 = fw * (0.5f + 0.5f * spread), y1 = fh * (0.15f + 0.2f * r[3]);
    float x2 = fw * (0.5f + 0.4f * spread), y2 = fh * (0.7f + 0.3f * r[4]);
    int steps = (int)(fw + fh);
    for (int i = 0; i < steps; i++) {
        float t = (float)i / (float)steps, s = 1 - t;
        float x = s * s * x0 + 2 * s * t * x1 + t * t * x2;
        float y = s * s * y0 + 2 * s * t * y1 + t * t * y2;
        float shine = expf(-60 * (t - 0.35f) * (t - 0.35f));
        float light = 0.35f + 0.5f * r[5];
        float colour[3] = {light * 0.55f + shine * 0.35f * r[3],
                           light * 0.36f + shine * 0.33f * r[3],
                           light * 0.22f + shine * 0.28f * r[3]};
        int ix = (int)x, iy = (int)y;
        if (ix < 0 || iy < 0 || ix + 1 >= w || iy >= h)
            continue;
        float *at = rgba + 4 * ((size_t)iy * (size_t)w + (size_t)ix);
        float part = x - (float)ix;
        picture_blend(at, colour, 0.6f * (1 - part));
        picture_blend(at + 4, colour, 0.6f * part);
    }
}

// Linear premultiplied float, [4 * w * h], transparent where no hair is.
static inline void picture_hair(float *rgba, int w, int h)
{
    uint64_t random = 20111117;
    memset(rgba, 0, sizeof(float) * 4 * (size_t)w * (size_t)h);
    for (int i = 0; i < 5 * w; i++)
        picture_strand(rgba, w, h, &random);
}

// Eight bits over a dark background, alpha = coverage.
static inline void picture_hair8(unsigned char *out, int w, int h)
{
    size_t n = (size_t)w * (size_t)h;
    float *rgba = bytes_alloc(sizeof(float) * 4 * n);
    picture_hair(rgba, w, h);
    for (size_t i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            out[4 * i + (size_t)c] =
                (unsigned char)(255 * powf(rgba[4 * i + (size_t)c] +
                                               0.035f * (1 - rgba[4 * i + 3]),
                                           0.4545f));
        out[4 * i + 3] = (unsigned char)(255 * rgba[4 * i + 3] + 0.5f);
    }
    free(rgba);
}

#endif
