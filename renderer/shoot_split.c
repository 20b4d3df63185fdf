// shoot_split.c - see the header.  Surface area heuristic over binned middles
// of boxes.  The top is split by one thread, the parts below by all; nothing
// depends on which.
#include "renderer/shoot_split.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/shoot_threads.h"

typedef int32_t i4 __attribute__((vector_size(16)));
typedef shoot_f4 f4;

enum {
    BINS = 16,
    CHUNK = 256,       // branches allocated at a time
    LOOK_ABOVE = 2048, // pieces: below, the watch is not looked at
    DEPTH_BINS = 40    // below it ranges are halved: 2^23 pieces end in 23 more
};

struct chunk {
    struct chunk *next;
    struct shoot_branch branch[CHUNK];
};

// What one thread makes: the top (part 0), or a branch that it left.
struct shoot_split_part {
    struct shoot_branch *root;
    struct chunk *chunk;
    int used; // of the newest chunk
    int depth;
};

struct split {
    struct shoot_split *out;
    uint32_t part_size; // ranges up to this become parts; 0: no more parts
    uint32_t part_cap;
    struct watch *watch; // NULL, or cuts it
};

// --- boxes -------------------------------------------------------------------

static inline f4 smaller(f4 a, f4 b)
{
    i4 m = a < b;
    return (f4)(((i4)a & m) | ((i4)b & ~m));
}

static inline f4 larger(f4 a, f4 b)
{
    i4 m = a > b;
    return (f4)(((i4)a & m) | ((i4)b & ~m));
}

static const struct shoot_box nothing = {{1e30f, 1e30f, 1e30f, 1e30f},
                                         {-1e30f, -1e30f, -1e30f, -1e30f}};

static inline void box_join(struct shoot_box *a, const struct shoot_box *b)
{
    a->low = smaller(a->low, b->low);
    a->high = larger(a->high, b->high);
}

static inline struct shoot_box box_of(const struct shoot_piece *p)
{
    struct shoot_box b;
    memcpy(&b.low, p->low, sizeof b.low);
    memcpy(&b.high, p->high, sizeof b.high);
    return b;
}

static inline float box_area(const struct shoot_box *b)
{
    f4 d = b->high - b->low;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

static inline f4 middle_of(const struct shoot_piece *p)
{
    struct shoot_box b = box_of(p);
    return b.low + b.high; // twice the middle: as good for sorting
}

static struct shoot_box range_box(const struct shoot_piece *p, uint32_t begin,
                                  uint32_t end)
{
    struct shoot_box box = nothing;
    for (uint32_t i = begin; i < end; i++) {
        struct shoot_box one = box_of(&p[i]);
        box_join(&box, &one);
    }
    return box;
}

// --- pieces ------------------------------------------------------------------

// A ray that meets the ribbon passes, at its closest approach, through the
// cylinder around the segment: the box of its two end discs holds it.
static void piece_box(struct shoot_piece *p, const float *a, const float *b)
{
    double e[3], length2 = 0;
    for (int k = 0; k < 3; k++) {
        e[k] = (double)b[k] - (double)a[k];
        length2 += e[k] * e[k];
    }
    for (int k = 0; k < 3; k++) {
        double across = sqrt(fmax(0, 1 - e[k] * e[k] / length2)) / 2;
        double ra = across * (double)a[3], rb = across * (double)b[3];
        double low = fmin((double)a[k] - ra, (double)b[k] - rb);
        double high = fmax((double)a[k] + ra, (double)b[k] + rb);
        p->low[k] = (float)(low - SHOOT_BOX_MARGIN);
        p->high[k] = (float)(high + SHOOT_BOX_MARGIN);
    }
}

static bool has_length(const float *a, const float *b)
{
    return a[0] != b[0] || a[1] != b[1] || a[2] != b[2];
}

static void make_pieces(struct shoot_split *s, const struct shoot_segments *in)
{
    s->piece = bytes_alloc((size_t)in->first[in->strands] * sizeof *s->piece);
    for (uint32_t k = 0; k < in->strands; k++)
        for (uint32_t i = in->first[k]; i + 1 < in->first[k + 1]; i++) {
            const float *a = in->point + 4 * (size_t)i;
            if (!has_length(a, a + 4))
                continue;
            struct shoot_piece *p = &s->piece[s->pieces++];
            *p = (struct shoot_piece){.segment = i};
            piece_box(p, a, a + 4);
        }
}

// --- where to split ----------------------------------------------------------

struct bin {
    struct shoot_box box;
    uint32_t count;
};

struct plane {
    int axis;         // -1: there is none
    float low, scale; // bin = (middle - low) * scale
    int bin;          // the first one of the right side
    struct shoot_box left, right;
};

static inline int bin_of(float middle, float low, float scale)
{
    int i = (int)((middle - low) * scale);
    return i < 0 ? 0 : i >= BINS ? BINS - 1 : i;
}

static void fill_bins(const struct shoot_piece *p, const uint32_t range[2],
                      f4 low, f4 scale, struct bin bin[3][BINS])
{
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < BINS; i++)
            bin[a][i] = (struct bin){nothing, 0};
    for (uint32_t i = range[0]; i < range[1]; i++) {
        struct shoot_box box = box_of(&p[i]);
        f4 middle = box.low + box.high;
        for (int a = 0; a < 3; a++) {
            struct bin *at = &bin[a][bin_of(middle[a], low[a], scale[a])];
            box_join(&at->box, &box);
            at->count++;
        }
    }
}

// Leaves hold eight: what counts is how many of them a side needs.
static inline float side_cost(const struct shoot_box *box, uint32_t count)
{
    return box_area(box) * (float)((count + SHOOT_LANES - 1) / SHOOT_LANES);
}

static void best_of_axis(const struct bin bin[BINS], int axis, float *best,
                         struct plane *s)
{
    struct shoot_box right[BINS];
    float right_cost[BINS];
    struct shoot_box sum = nothing;
    uint32_t count = 0;
    for (int i = BINS - 1; i > 0; i--) {
        box_join(&sum, &bin[i].box);
        count += bin[i].count;
        right[i] = sum;
        right_cost[i] = count > 0 ? side_cost(&sum, count) : INFINITY;
    }
    sum = nothing;
    count = 0;
    for (int i = 1; i < BINS; i++) {
        box_join(&sum, &bin[i - 1].box);
        count += bin[i - 1].count;
        if (count == 0)
            continue;
        float cost = side_cost(&sum, count) + right_cost[i];
        if (cost < *best) {
            *best = cost;
            s->axis = axis;
            s->bin = i;
            s->left = sum;
            s->right = right[i];
        }
    }
}

static struct plane find_plane(const struct shoot_piece *p,
                               const uint32_t range[2])
{
    struct shoot_box middles = nothing;
    for (uint32_t i = range[0]; i < range[1]; i++) {
        f4 m = middle_of(&p[i]);
        middles.low = smaller(middles.low, m);
        middles.high = larger(middles.high, m);
    }
    f4 scale = {0};
    for (int a = 0; a < 3; a++) {
        float width = middles.high[a] - middles.low[a];
        scale[a] = width > 1e-12f ? BINS * 0.9999f / width : 0;
    }
    struct bin bin[3][BINS];
    fill_bins(p, range, middles.low, scale, bin);
    struct plane s = {.axis = -1};
    float best = INFINITY;
    for (int a = 0; a < 3; a++)
        if (scale[a] > 0)
            best_of_axis(bin[a], a, &best, &s);
    if (s.axis >= 0) {
        s.low = middles.low[s.axis];
        s.scale = scale[s.axis];
    }
    return s;
}

static bool is_left(const struct shoot_piece *p, const struct plane *s)
{
    return bin_of(middle_of(p)[s->axis], s->low, s->scale) < s->bin;
}

static uint32_t partition(struct shoot_piece *p, const uint32_t range[2],
                          const struct plane *s)
{
    uint32_t i = range[0], j = range[1];
    for (;;) {
        while (i < j && is_left(&p[i], s))
            i++;
        while (i < j && !is_left(&p[j - 1], s))
            j--;
        if (i >= j)
            return i;
        struct shoot_piece swap = p[i];
        p[i] = p[j - 1];
        p[j - 1] = swap;
    }
}

// --- branches ----------------------------------------------------------------

static struct shoot_branch *new_branch(struct shoot_split_part *part,
                                       const struct shoot_box *box,
                                       uint32_t begin, uint32_t end)
{
    if (!part->chunk || part->used == CHUNK) {
        struct chunk *c = bytes_alloc(sizeof *c);
        c->next = part->chunk;
        part->chunk = c;
        part->used = 0;
    }
    struct shoot_branch *b = &part->chunk->branch[part->used++];
    memset(b, 0, sizeof *b);
    b->box = *box;
    b->begin = begin;
    b->end = end;
    return b;
}

// The two sides of a branch: by a plane, or halves where none is any good, or
// so deep that the pieces must be degenerate.
static void halve(struct shoot_piece *p, struct shoot_split_part *part,
                  struct shoot_branch *b, int depth)
{
    const uint32_t range[2] = {b->begin, b->end};
    struct plane s = {.axis = -1};
    if (depth < DEPTH_BINS)
        s = find_plane(p, range);
    uint32_t at = b->begin + (b->end - b->begin) / 2;
    if (s.axis >= 0) {
        at = partition(p, range, &s);
    } else {
        s.left = range_box(p, b->begin, at);
        s.right = range_box(p, at, b->end);
    }
    b->left = new_branch(part, &s.left, b->begin, at);
    b->right = new_branch(part, &s.right, at, b->end);
}

// The cheapest wide tree over a tree of two (Ylitie, Karras and Laine 2017,
// section 3.1): visiting a node or a leaf costs the same, as often as its box
// is met.
static void price(struct shoot_branch *b)
{
    const float area = box_area(&b->box);
    if (!b->left) {
        for (int k = 1; k <= SHOOT_LANES; k++)
            b->cost[k] = area;
        return;
    }
    float best[SHOOT_LANES + 1];
    uint8_t share[SHOOT_LANES + 1];
    for (int k = 2; k <= SHOOT_LANES; k++) {
        best[k] = INFINITY;
        for (int m = 1; m < k; m++) {
            float cost = b->left->cost[m] + b->right->cost[k - m];
            if (cost < best[k]) {
                best[k] = cost;
                share[k] = (uint8_t)m;
            }
        }
    }
    b->share[0] = share[SHOOT_LANES];
    b->cost[1] = area + best[SHOOT_LANES];
    b->share[1] = 0;
    for (int k = 2; k <= SHOOT_LANES; k++) {
        bool spread = best[k] < b->cost[1];
        b->cost[k] = spread ? best[k] : b->cost[1];
        b->share[k] = spread ? share[k] : 0;
    }
}

static void leave(struct split *s, struct shoot_branch *b, int depth)
{
    struct shoot_split *out = s->out;
    if (out->parts == s->part_cap) {
        s->part_cap *= 2;
        out->part = bytes_realloc(out->part, s->part_cap * sizeof *out->part);
    }
    out->part[out->parts++] =
        (struct shoot_split_part){.root = b, .depth = depth};
}

static void grow(struct split *s, struct shoot_split_part *part,
                 struct shoot_branch *b, int depth)
{
    const uint32_t count = b->end - b->begin;
    if (count > LOOK_ABOVE && watch_cut(s->watch))
        return;
    if (s->part_size > 0 && count <= s->part_size) {
        leave(s, b, depth);
        return;
    }
    if (count > SHOOT_LANES) {
        halve(s->out->piece, part, b, depth);
        grow(s, part, b->left, depth + 1);
        grow(s, part, b->right, depth + 1);
    }
    if (s->part_size == 0)
        price(b);
}

static void grow_part(void *context, size_t i)
{
    struct split *s = context;
    struct shoot_split_part *part = &s->out->part[i + 1];
    grow(s, part, part->root, part->depth);
}

// The top's prices, when the parts below have theirs.
static void price_top(struct shoot_branch *b, uint32_t part_size)
{
    if (b->end - b->begin <= part_size)
        return;
    price_top(b->left, part_size);
    price_top(b->right, part_size);
    price(b);
}

void shoot_split(struct shoot_split *out, const struct shoot_segments *in)
{
    *out = (struct shoot_split){0};
    make_pieces(out, in);
    const uint32_t size = out->pieces / 64 > 4096 ? out->pieces / 64 : 4096;
    struct split s = {
        .out = out, .part_size = size, .part_cap = 256, .watch = in->watch};
    out->part = bytes_zalloc(s.part_cap, sizeof *out->part);
    out->parts = 1;
    struct shoot_split_part top = {0};
    struct shoot_box box = range_box(out->piece, 0, out->pieces);
    out->root = new_branch(&top, &box, 0, out->pieces);
    grow(&s, &top, out->root, 0);
    out->part[0] = top;
    s.part_size = 0;
    shoot_threads(out->parts - 1, grow_part, &s);
    if (!watch_cut(in->watch))
        price_top(out->root, size);
}

void shoot_split_finish(struct shoot_split *s)
{
    for (uint32_t i = 0; i < s->parts; i++)
        for (struct chunk *c = s->part[i].chunk, *next; c; c = next) {
            next = c->next;
            free(c);
        }
    free(s->part);
    free(s->piece);
    *s = (struct shoot_split){0};
}
