// crossings_lists.c - for each cell the segments that touch it, as wide as
// they are.  Two passes, counting and filling.
#include "renderer/crossings_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

struct box {
    int low[3], high[3]; // cells, both included
};

// Does the segment a, b touch the cell grown by r?
static bool touches(const float a[3], const float b[3], const int cell[3],
                    float r)
{
    float from = 0, to = 1;
    for (int k = 0; k < 3; k++) {
        const float low = (float)cell[k] - r, high = (float)cell[k] + 1 + r;
        const float d = b[k] - a[k];
        if (fabsf(d) < 1e-12f) {
            if (a[k] < low || a[k] > high)
                return false;
            continue;
        }
        const float s = (low - a[k]) / d, t = (high - a[k]) / d;
        from = fmaxf(from, fminf(s, t));
        to = fminf(to, fmaxf(s, t));
    }
    return from <= to;
}

static struct box box_of(const float a[3], const float b[3], float r,
                         const int size[3])
{
    struct box x;
    for (int k = 0; k < 3; k++) {
        const float most = (float)(size[k] - 1);
        const float low = floorf(fminf(a[k], b[k]) - r);
        const float high = floorf(fmaxf(a[k], b[k]) + r);
        x.low[k] = (int)fminf(fmaxf(low, 0), most);
        x.high[k] = (int)fminf(fmaxf(high, 0), most);
    }
    return x;
}

// Adds segment i to counts[cell], or puts it where counts[cell] says.
// Returns in how many cells it is.
static uint32_t place(const struct crossings_hair *h, uint32_t i,
                      const int size[3], uint32_t *counts, uint32_t *pieces)
{
    const float *a = h->at + 4 * (size_t)i, *b = a + 4;
    const float r = 0.5f * fmaxf(a[3], b[3]) + 1e-4f; // and rounding
    const struct box box = box_of(a, b, r, size);
    uint32_t n = 0;
    int v[3];
    for (v[2] = box.low[2]; v[2] <= box.high[2]; v[2]++)
        for (v[1] = box.low[1]; v[1] <= box.high[1]; v[1]++)
            for (v[0] = box.low[0]; v[0] <= box.high[0]; v[0]++) {
                if (!touches(a, b, v, r))
                    continue;
                const size_t at =
                    ((size_t)v[2] * (size_t)size[1] + (size_t)v[1]) *
                        (size_t)size[0] +
                    (size_t)v[0];
                if (pieces)
                    pieces[counts[at]] = i;
                counts[at]++;
                n++;
            }
    return n;
}

static bool pass(const struct crossings_hair *h, const int size[3],
                 uint64_t most, uint32_t *counts, uint32_t *pieces)
{
    uint64_t total = 0;
    for (uint32_t k = 0; k < h->strands; k++)
        for (uint32_t i = h->first[k]; i + 1 < h->first[k + 1]; i++) {
            total += place(h, i, size, counts, pieces);
            if (total > most)
                return false;
        }
    return true;
}

bool crossings_lists_make(const struct crossings_hair *h, const int size[3],
                          uint64_t most, uint32_t *starts, uint32_t **pieces)
{
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    if (!pass(h, size, most, starts, NULL))
        return false;
    uint32_t sum = 0;
    for (size_t i = 0; i <= cells; i++) {
        const uint32_t n = i < cells ? starts[i] : 0;
        starts[i] = sum;
        sum += n;
    }
    *pieces = bytes_alloc(((size_t)sum + 1) * sizeof **pieces);
    (*pieces)[sum] = 0;
    pass(h, size, most, starts, *pieces);
    // each now holds where the next begins
    memmove(starts + 1, starts, cells * sizeof *starts);
    starts[0] = 0;
    return true;
}
