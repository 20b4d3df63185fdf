// draft.c - what a draft owns.  How it is made is renderer_draft.c's affair.
#include "renderer/draft.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

static void finish_view(struct draft_view *v)
{
    picture_finish(&v->picture);
    display_finish(&v->display);
    nodes_finish(&v->nodes);
    memset(v, 0, sizeof *v);
}

// The fit is no picture's, and stays.
void draft_finish(struct draft *d)
{
    for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++)
        finish_view(&d->view[i]);
    strands_finish(&d->strands);
    crossings_finish(&d->crossings);
    d->shown = d->now = NULL;
    d->stride = d->gridded = 0;
    d->swept.known = false;
    d->as_if = RENDERER_STAGES;
}

uint64_t draft_bytes(const struct draft *d)
{
    const struct crossings_stats *c = &d->crossings.stats;
    uint64_t sum =
        d->strands.bytes + c->grid_bytes + c->ways_bytes + c->scratch_bytes;
    for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++) {
        const struct draft_view *v = &d->view[i];
        sum += v->picture.target_bytes + v->picture.cache_bytes +
               display_bytes(&v->display) + v->nodes.first.bytes +
               v->nodes.rest.bytes;
    }
    return sum;
}

struct draft_view *draft_view_of(struct draft *d,
                                 const struct renderer_draft *how)
{
    struct draft_view *best = &d->view[0];
    for (int i = 0; i < RENDERER_DRAFT_VIEWS; i++) {
        struct draft_view *v = &d->view[i];
        if (v->how.divisor == how->divisor && v->how.stride == how->stride)
            return v;
        if (v->age < best->age)
            best = v;
    }
    return best;
}

void draft_view_take(struct draft *d, struct draft_view *v,
                     const struct renderer_draft *how)
{
    if (v->how.divisor != how->divisor || v->how.stride != how->stride)
        v->seen = false;
    v->how.divisor = how->divisor;
    v->how.stride = how->stride;
    v->age = ++d->clock;
}

bool draft_lights_same(const struct draft_lights *a, const struct lights *l)
{
    return a->known && a->count == l->used &&
           memcmp(a->place, l->place, sizeof a->place) == 0;
}

void draft_lights_note(struct draft_lights *a, const struct lights *l)
{
    a->known = true;
    a->count = l->used;
    memcpy(a->place, l->place, sizeof a->place);
}

// Where in 0 .. n - 1 the middle of pixel i of `wanted` lies: before which, and
// how far behind it in 1/128.
static int between(int i, int n, int wanted, int *after)
{
    const int64_t at = ((int64_t)(2 * i + 1) * n * 128) / (2 * wanted) - 64;
    const int64_t end = (int64_t)(n - 1) * 128;
    const int64_t in = at < 0 ? 0 : at > end ? end : at;
    *after = (int)(in % 128);
    return (int)(in / 128);
}

// A row as wide as wanted; values times 128.
static void widen(const uint8_t *row, int n, uint16_t *out, int wanted)
{
    for (int x = 0; x < wanted; x++) {
        int t;
        const int i = between(x, n, wanted, &t);
        const uint8_t *a = row + 4 * i, *b = i + 1 < n ? a + 4 : a;
        for (int c = 0; c < 4; c++)
            out[4 * x + c] = (uint16_t)((128 - t) * a[c] + t * b[c]);
    }
}

// Straight alpha cannot be interpolated, premultiplied colour can.
static void multiply(uint8_t *p, size_t pixels, bool back)
{
    for (size_t i = 0; i < 4 * pixels; i += 4) {
        const unsigned a = p[i + 3];
        if (a == 255 || (back && a == 0))
            continue;
        for (size_t c = i; c < i + 3; c++) {
            const unsigned v =
                back ? (255u * p[c] + a / 2) / a : (p[c] * a + 127) / 255;
            p[c] = (uint8_t)(v > 255 ? 255 : v);
        }
    }
}

void draft_enlarge(const uint8_t *from, const int size[2], uint8_t *to,
                   const int wanted[2])
{
    const size_t pixels = (size_t)size[0] * (size_t)size[1];
    const size_t wide = 4 * (size_t)wanted[0];
    uint8_t *whole = memcpy(bytes_alloc(4 * pixels), from, 4 * pixels);
    uint16_t *row = bytes_alloc(wide * (size_t)size[1] * sizeof *row);
    multiply(whole, pixels, false);
    for (int y = 0; y < size[1]; y++)
        widen(whole + 4 * (size_t)size[0] * (size_t)y, size[0],
              row + wide * (size_t)y, wanted[0]);
    for (int y = 0; y < wanted[1]; y++) {
        int t;
        const int i = between(y, size[1], wanted[1], &t);
        const uint16_t *a = row + wide * (size_t)i;
        const uint16_t *b = i + 1 < size[1] ? a + wide : a;
        uint8_t *out = to + wide * (size_t)y;
        for (size_t x = 0; x < wide; x++)
            out[x] = (uint8_t)(((uint32_t)(128 - t) * a[x] +
                                (uint32_t)t * b[x] + 8192) >>
                               14);
    }
    multiply(to, (size_t)wanted[0] * (size_t)wanted[1], true);
    free(row);
    free(whole);
}
