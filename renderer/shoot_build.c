// shoot_build.c - makes the wide tree of shoot_tree.h out of shoot_split.c's
// branches: which of them become nodes was priced there.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "renderer/shoot_split.h"
#include "renderer/shoot_tree.h"

struct build {
    struct shoot_tree *tree;
    const struct shoot_segments *in;
    const struct shoot_split *split;
};

// --- memory ------------------------------------------------------------------

// Whole cache lines, and large pages: a walk is random access, and would spend
// much of its time in looking up small ones.
static void *aligned(size_t size)
{
    const size_t page = (size_t)2 << 20;
    const size_t unit = size < page ? 64 : page;
    size = (size + unit) / unit * unit;
    void *p = aligned_alloc(unit, size);
    if (!p)
        abort(); // as bytes_alloc
    if (unit == page)
        madvise(p, size, MADV_HUGEPAGE);
    return p;
}

// --- nodes and leaves --------------------------------------------------------

static uint32_t put_leaf(struct build *b, const struct shoot_branch *from)
{
    struct shoot_leaf *l = &b->tree->leaf[b->tree->leaves];
    memset(l, 0, sizeof *l);
    for (uint32_t i = 0; i < SHOOT_LANES; i++) {
        l->radius[i] = NAN;
        if (from->begin + i >= from->end)
            continue;
        l->segment[i] = b->split->piece[from->begin + i].segment;
        const float *p = b->in->point + 4 * (size_t)l->segment[i];
        for (int k = 0; k < 3; k++) {
            l->a[k][i] = p[k];
            l->b[k][i] = p[4 + k];
        }
        l->radius[i] = fmaxf(p[3], p[7]) / 2;
    }
    return SHOOT_LEAF | (uint32_t)b->tree->leaves++;
}

static uint32_t new_node(struct shoot_tree *t)
{
    struct shoot_node *n = &t->node[t->nodes];
    for (int i = 0; i < SHOOT_LANES; i++) {
        n->child[i] = SHOOT_NONE;
        n->unused[i] = 0;
        for (int k = 0; k < 3; k++) {
            n->side[0][k][i] = 1e30f; // an inside-out box: never met
            n->side[1][k][i] = -1e30f;
        }
    }
    return (uint32_t)t->nodes++;
}

// The branches that take a branch's `places` places.
static int spread(const struct shoot_branch *b, int places,
                  const struct shoot_branch **out)
{
    const int left = b->left ? b->share[places] : 0;
    if (left == 0) {
        *out = b;
        return 1;
    }
    int n = spread(b->left, left, out);
    return n + spread(b->right, places - left, out + n);
}

static uint32_t put_node(struct build *b, const struct shoot_branch *from)
{
    struct shoot_tree *t = b->tree;
    const struct shoot_branch *child[SHOOT_LANES];
    int n = 1;
    child[0] = from;
    if (from->left) {
        const int left = from->share[0];
        n = spread(from->left, left, child);
        n += spread(from->right, SHOOT_LANES - left, child + n);
    } else if (from->begin == from->end) {
        n = 0; // a scene without any length
    }
    const uint32_t index = new_node(t);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++) {
            t->node[index].side[0][k][i] = child[i]->box.low[k];
            t->node[index].side[1][k][i] = child[i]->box.high[k];
        }
        t->node[index].child[i] =
            child[i]->left ? put_node(b, child[i]) : put_leaf(b, child[i]);
    }
    return index;
}

static void count(const struct shoot_branch *b, size_t *inner, size_t *leaves)
{
    if (!b->left) {
        ++*leaves;
        return;
    }
    ++*inner;
    count(b->left, inner, leaves);
    count(b->right, inner, leaves);
}

bool shoot_build(struct shoot_tree *t, const struct shoot_segments *segments)
{
    struct shoot_split split;
    shoot_split(&split, segments);
    struct build b = {t, segments, &split};
    *t = (struct shoot_tree){0};
    if (watch_cut(segments->watch)) {
        shoot_split_finish(&split);
        return false;
    }
    for (int k = 0; k < 3; k++) {
        t->low[k] = split.root->box.low[k];
        t->high[k] = split.root->box.high[k];
    }
    size_t inner = 1, leaves = 0; // at most; pages never touched cost nothing
    count(split.root, &inner, &leaves);
    t->node = aligned(inner * sizeof *t->node);
    t->leaf = aligned(leaves * sizeof *t->leaf);
    put_node(&b, split.root);
    shoot_split_finish(&split);
    return true;
}

void shoot_build_finish(struct shoot_tree *t)
{
    free(t->node);
    free(t->leaf);
    *t = (struct shoot_tree){0};
}
