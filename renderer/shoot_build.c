// shoot_build.c - the hierarchy over segments: surface area heuristic over
// binned centroids, four children a node, four segments a leaf.  The top is
// split by one thread, the parts below by all; parts are joined in order, so
// the tree does not depend on the number of threads.
#include "renderer/shoot_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/shoot_threads.h"

enum { BINS = 16, PIECES_MAX = 16 };

struct piece { // one stretch of a segment, and its box
    float low[3];
    uint32_t segment;
    float high[3];
    uint16_t from, to;
};

struct box {
    shoot_f4 low, high; // lane 3 is not used
};

struct range {
    uint32_t begin, end;
    struct box box;
};

struct job {       // a part of the tree left to another thread
    uint32_t node; // of the top, and
    int lane;      // where its root goes
    struct range range;
    int depth;
    struct part *part;
};

struct part { // a growing piece of the tree
    struct shoot_node *node;
    struct shoot_leaf *leaf;
    uint32_t nodes, leaves, node_cap, leaf_cap;
};

struct build {
    const struct shoot_segments *in;
    struct piece *piece;
    uint32_t pieces;
    struct job *job;
    uint32_t jobs, job_cap;
    uint32_t job_size; // ranges up to this size are jobs; 0: no more jobs
};

// --- boxes -------------------------------------------------------------------

static inline shoot_f4 smaller(shoot_f4 a, shoot_f4 b)
{
    shoot_i4 m = a < b;
    return (shoot_f4)(((shoot_i4)a & m) | ((shoot_i4)b & ~m));
}

static inline shoot_f4 larger(shoot_f4 a, shoot_f4 b)
{
    shoot_i4 m = a > b;
    return (shoot_f4)(((shoot_i4)a & m) | ((shoot_i4)b & ~m));
}

static const struct box nothing = {{1e30f, 1e30f, 1e30f, 1e30f},
                                   {-1e30f, -1e30f, -1e30f, -1e30f}};

static inline void box_join(struct box *a, const struct box *b)
{
    a->low = smaller(a->low, b->low);
    a->high = larger(a->high, b->high);
}

static inline struct box box_of(const struct piece *p)
{
    struct box b;
    memcpy(&b.low, p->low, sizeof b.low);
    memcpy(&b.high, p->high, sizeof b.high);
    return b;
}

static inline float box_area(const struct box *b)
{
    shoot_f4 d = b->high - b->low;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

static inline shoot_f4 middle_of(const struct piece *p)
{
    struct box b = box_of(p);
    return b.low + b.high; // twice the middle: as good for sorting
}

// --- pieces ------------------------------------------------------------------

// A ray that meets the ribbon passes, at its closest approach, through the
// cylinder around the segment: the box of its two end discs holds it.
static void piece_box(struct piece *p, const float *a, const float *b)
{
    double e[3], length2 = 0;
    for (int k = 0; k < 3; k++) {
        e[k] = (double)b[k] - (double)a[k];
        length2 += e[k] * e[k];
    }
    double u[2] = {(double)p->from / SHOOT_PARTS, (double)p->to / SHOOT_PARTS};
    for (int k = 0; k < 3; k++) {
        double across = sqrt(fmax(0, 1 - e[k] * e[k] / length2));
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < 2; i++) {
            double x = (double)a[k] + u[i] * e[k];
            double r =
                0.5 * ((double)a[3] + u[i] * ((double)b[3] - (double)a[3]));
            low = fmin(low, x - across * r);
            high = fmax(high, x + across * r);
        }
        p->low[k] = (float)(low - SHOOT_BOX_MARGIN);
        p->high[k] = (float)(high + SHOOT_BOX_MARGIN);
    }
}

static bool has_length(const float *a, const float *b)
{
    return a[0] != b[0] || a[1] != b[1] || a[2] != b[2];
}

static void make_pieces(struct build *b)
{
    const struct shoot_segments *in = b->in;
    b->piece = bytes_alloc((size_t)in->first[in->strands] * sizeof *b->piece);
    for (uint32_t s = 0; s < in->strands; s++)
        for (uint32_t i = in->first[s]; i + 1 < in->first[s + 1]; i++) {
            const float *a = in->point + 4 * (size_t)i;
            if (!has_length(a, a + 4))
                continue;
            struct piece *p = &b->piece[b->pieces++];
            *p = (struct piece){.segment = i, .from = 0, .to = SHOOT_PARTS};
            piece_box(p, a, a + 4);
        }
}

// --- splitting ---------------------------------------------------------------

struct bin {
    struct box box;
    uint32_t count;
};

struct split {
    int axis;         // -1: none is better than halves
    float low, scale; // bin = (middle - low) * scale
    int bin;          // the first one of the right side
    struct box left, right;
};

static inline int bin_of(float middle, float low, float scale)
{
    int i = (int)((middle - low) * scale);
    return i < 0 ? 0 : i >= BINS ? BINS - 1 : i;
}

static void fill_bins(const struct build *b, const struct range *r,
                      shoot_f4 low, shoot_f4 scale, struct bin bin[3][BINS])
{
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < BINS; i++)
            bin[a][i] = (struct bin){nothing, 0};
    for (uint32_t i = r->begin; i < r->end; i++) {
        struct box box = box_of(&b->piece[i]);
        shoot_f4 middle = box.low + box.high;
        for (int a = 0; a < 3; a++) {
            struct bin *at = &bin[a][bin_of(middle[a], low[a], scale[a])];
            box_join(&at->box, &box);
            at->count++;
        }
    }
}

// Leaves hold four: what counts is how many tests of four a side needs.
static inline float side_cost(const struct box *box, uint32_t count)
{
    return box_area(box) * (float)((count + SHOOT_LANES - 1) / SHOOT_LANES);
}

static void best_of_axis(const struct bin bin[BINS], int axis, float *best,
                         struct split *s)
{
    struct box right[BINS];
    float right_cost[BINS];
    struct box sum = nothing;
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

static struct split find_split(const struct build *b, const struct range *r)
{
    struct box middles = nothing;
    for (uint32_t i = r->begin; i < r->end; i++) {
        shoot_f4 m = middle_of(&b->piece[i]);
        middles.low = smaller(middles.low, m);
        middles.high = larger(middles.high, m);
    }
    shoot_f4 scale = {0};
    for (int a = 0; a < 3; a++) {
        float width = middles.high[a] - middles.low[a];
        scale[a] = width > 1e-12f ? BINS * 0.9999f / width : 0;
    }
    struct bin bin[3][BINS];
    fill_bins(b, r, middles.low, scale, bin);
    struct split s = {.axis = -1};
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

static uint32_t partition(struct piece *p, uint32_t begin, uint32_t end,
                          const struct split *s)
{
    uint32_t i = begin, j = end;
    for (;;) {
        while (i < j &&
               bin_of(middle_of(&p[i])[s->axis], s->low, s->scale) < s->bin)
            i++;
        while (i < j && bin_of(middle_of(&p[j - 1])[s->axis], s->low,
                               s->scale) >= s->bin)
            j--;
        if (i >= j)
            return i;
        struct piece swap = p[i];
        p[i] = p[j - 1];
        p[j - 1] = swap;
    }
}

static struct box range_box(const struct build *b, uint32_t begin, uint32_t end)
{
    struct box box = nothing;
    for (uint32_t i = begin; i < end; i++) {
        struct box one = box_of(&b->piece[i]);
        box_join(&box, &one);
    }
    return box;
}

static void split_range(struct build *b, struct range *left,
                        struct range *right, int depth)
{
    struct range r = *left;
    struct split s = {.axis = -1};
    // Deep means degenerate: from there on halves, which end soon.
    if (depth < SHOOT_DEPTH_MAX / 2)
        s = find_split(b, &r);
    uint32_t at = r.begin + (r.end - r.begin) / 2;
    if (s.axis >= 0) {
        at = partition(b->piece, r.begin, r.end, &s);
    } else {
        s.left = range_box(b, r.begin, at);
        s.right = range_box(b, at, r.end);
    }
    *left = (struct range){r.begin, at, s.left};
    *right = (struct range){at, r.end, s.right};
}

// --- nodes -------------------------------------------------------------------

static uint32_t new_node(struct part *p)
{
    if (p->nodes == p->node_cap) {
        p->node_cap = p->node_cap ? p->node_cap + p->node_cap / 2 : 64;
        p->node = bytes_realloc(p->node, p->node_cap * sizeof *p->node);
    }
    struct shoot_node *n = &p->node[p->nodes];
    memset(n, 0, sizeof *n);
    for (int k = 0; k < 3; k++) {
        n->side[0][k] = nothing.low; // an inside-out box: never met
        n->side[1][k] = nothing.high;
    }
    for (int i = 0; i < SHOOT_LANES; i++)
        n->child[i] = SHOOT_NONE;
    return p->nodes++;
}

static uint32_t new_leaf(const struct build *b, struct part *part,
                         const struct range *r)
{
    if (part->leaves == part->leaf_cap) {
        part->leaf_cap =
            part->leaf_cap ? part->leaf_cap + part->leaf_cap / 2 : 64;
        part->leaf =
            bytes_realloc(part->leaf, part->leaf_cap * sizeof *part->leaf);
    }
    struct shoot_leaf *l = &part->leaf[part->leaves];
    memset(l, 0, sizeof *l);
    for (int lane = 0; lane < SHOOT_LANES; lane++) {
        const bool used = r->begin + (uint32_t)lane < r->end;
        const struct piece *p =
            &b->piece[r->begin + (used ? (uint32_t)lane : 0)];
        const float *a = b->in->point + 4 * (size_t)p->segment;
        for (int k = 0; k < 3; k++) {
            l->a[k][lane] = used ? a[k] : NAN;
            l->b[k][lane] = used ? a[4 + k] : NAN;
        }
        l->radius_a[lane] = a[3] / 2;
        l->radius_b[lane] = a[7] / 2;
        float reach = fmaxf(a[3], a[7]) / 2 + (float)SHOOT_REACH_MARGIN;
        l->reach2[lane] = used ? reach * reach : NAN;
        l->segment[lane] = p->segment;
        l->from[lane] = p->from;
        l->to[lane] = p->to;
    }
    return part->leaves++;
}

static void put_job(struct build *b, uint32_t node, int lane, int depth,
                    const struct range *r)
{
    if (b->jobs == b->job_cap) {
        b->job_cap = b->job_cap ? 2 * b->job_cap : 64;
        b->job = bytes_realloc(b->job, b->job_cap * sizeof *b->job);
    }
    b->job[b->jobs++] = (struct job){node, lane, *r, depth, NULL};
}

// Splits the largest of up to four ranges until there are four.
static int spread(struct build *b, struct range r[SHOOT_LANES], int depth)
{
    int n = 1;
    while (n < SHOOT_LANES) {
        int pick = -1;
        float most = -1;
        for (int i = 0; i < n; i++) {
            float area = box_area(&r[i].box);
            if (r[i].end - r[i].begin > SHOOT_LANES && area > most) {
                most = area;
                pick = i;
            }
        }
        if (pick < 0)
            break;
        split_range(b, &r[pick], &r[n++], depth);
    }
    return n;
}

static uint32_t build_node(struct build *b, struct part *part,
                           const struct range *whole, int depth)
{
    struct range r[SHOOT_LANES] = {*whole};
    int n = spread(b, r, depth);
    uint32_t index = new_node(part);
    for (int i = 0; i < n; i++) {
        uint32_t child, count = r[i].end - r[i].begin;
        if (count == 0) // a scene without any length
            break;
        if (count <= SHOOT_LANES) {
            child = SHOOT_LEAF | new_leaf(b, part, &r[i]);
        } else if (count <= b->job_size) {
            put_job(b, index, i, depth + 1, &r[i]);
            child = SHOOT_NONE; // until the parts are joined
        } else {
            child = build_node(b, part, &r[i], depth + 1);
        }
        struct shoot_node *node = &part->node[index];
        for (int k = 0; k < 3; k++) {
            node->side[0][k][i] = r[i].box.low[k];
            node->side[1][k][i] = r[i].box.high[k];
        }
        node->child[i] = child;
    }
    return index;
}

// --- parts -------------------------------------------------------------------

static void do_job(void *context, size_t i)
{
    struct build *b = context;
    struct job *j = &b->job[i];
    build_node(b, j->part, &j->range, j->depth);
}

static void append(struct shoot_tree *t, const struct part *p)
{
    for (uint32_t i = 0; i < p->nodes; i++) {
        struct shoot_node *n = &t->node[t->nodes + i];
        *n = p->node[i];
        for (int c = 0; c < SHOOT_LANES; c++)
            if (n->child[c] == SHOOT_NONE)
                continue;
            else if (n->child[c] & SHOOT_LEAF)
                n->child[c] += (uint32_t)t->leaves;
            else
                n->child[c] += (uint32_t)t->nodes;
    }
    if (p->leaves > 0)
        memcpy(t->leaf + t->leaves, p->leaf, p->leaves * sizeof *p->leaf);
    t->nodes += p->nodes;
    t->leaves += p->leaves;
}

// Whole cache lines: a node lies in two of them.
static void *aligned(size_t size)
{
    void *p = aligned_alloc(64, (size + 64) / 64 * 64);
    if (!p)
        abort(); // as bytes_alloc
    return p;
}

static void join_parts(struct shoot_tree *t, struct build *b,
                       const struct part *part)
{
    size_t nodes = 0, leaves = 0;
    for (uint32_t i = 0; i <= b->jobs; i++) {
        nodes += part[i].nodes;
        leaves += part[i].leaves;
    }
    t->node = aligned(nodes * sizeof *t->node);
    t->leaf = aligned(leaves * sizeof *t->leaf);
    append(t, &part[0]);
    for (uint32_t i = 0; i < b->jobs; i++) {
        t->node[b->job[i].node].child[b->job[i].lane] = (uint32_t)t->nodes;
        append(t, &part[i + 1]);
    }
}

void shoot_build(struct shoot_tree *t, const struct shoot_segments *segments)
{
    struct build b = {.in = segments};
    make_pieces(&b);
    b.job_size = b.pieces / 32 > 4096 ? b.pieces / 32 : 4096;
    struct range all = {0, b.pieces, range_box(&b, 0, b.pieces)};
    for (int k = 0; k < 3; k++) {
        t->low[k] = all.box.low[k];
        t->high[k] = all.box.high[k];
    }
    struct part top = {0};
    build_node(&b, &top, &all, 0);
    b.job_size = 0;
    struct part *part = bytes_zalloc(b.jobs + 1, sizeof *part);
    part[0] = top;
    for (uint32_t i = 0; i < b.jobs; i++)
        b.job[i].part = &part[i + 1];
    shoot_threads(b.jobs, do_job, &b);
    join_parts(t, &b, part);
    for (uint32_t i = 0; i <= b.jobs; i++) {
        free(part[i].node);
        free(part[i].leaf);
    }
    free(part);
    free(b.job);
    free(b.piece);
}

void shoot_build_finish(struct shoot_tree *t)
{
    free(t->node);
    free(t->leaf);
    *t = (struct shoot_tree){0};
}
