// encode_huffman.c - lengths by the two-queue method on sorted counts, or,
// where a code would be too long, by packages; then canonical codes.
#include "renderer/encode_huffman.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct leaf {
    uint32_t use;
    int symbol;
};

static int by_use(const void *a, const void *b)
{
    const struct leaf *x = a, *y = b;
    if (x->use != y->use)
        return x->use < y->use ? -1 : 1;
    return x->symbol - y->symbol; // qsort need not be stable
}

// Depth of each leaf, leaves sorted by rising use.
static void depths(const struct leaf *leaf, int n, int *depth)
{
    uint64_t weight[2 * ENCODE_HUFFMAN_MAX];
    int parent[2 * ENCODE_HUFFMAN_MAX] = {0};
    int leaves = 0, inner = n, made = n;
    for (int i = 0; i < n; i++)
        weight[i] = leaf[i].use;
    for (; made < 2 * n - 1; made++) {
        weight[made] = 0;
        for (int k = 0; k < 2; k++) {
            int take =
                leaves < n && (inner == made || weight[leaves] <= weight[inner])
                    ? leaves++
                    : inner++;
            weight[made] += weight[take];
            parent[take] = made;
        }
    }
    int deep[2 * ENCODE_HUFFMAN_MAX];
    deep[2 * n - 2] = 0;
    for (int i = 2 * n - 3; i >= 0; i--)
        deep[i] = deep[parent[i]] + 1;
    for (int i = 0; i < n; i++)
        depth[i] = deep[i];
}

// The best depths of which none exceeds `longest`, by packages (Larmore and
// Hirschberg 1990): at each level two neighbours of the level below are bound
// together and sorted in among the leaves.  The 2n - 2 lightest of the top
// level are taken; those are leaves, and packages, whose contents are taken
// below.  Slower than depths(), and rarely needed.
static void limit(const struct leaf *leaf, int n, int longest, int *depth)
{
    uint64_t weight[2][2 * ENCODE_HUFFMAN_MAX];
    bool package[16][2 * ENCODE_HUFFMAN_MAX];
    int size = 0;
    for (int level = 0; level < longest; level++) {
        const uint64_t *below = weight[level & 1];
        uint64_t *here = weight[~level & 1];
        int pairs = size / 2, p = 0, next = 0;
        for (size = 0; size < n + pairs; size++) {
            uint64_t both = p < pairs ? below[2 * p] + below[2 * p + 1] : 0;
            package[level][size] =
                next == n || (p < pairs && both < leaf[next].use);
            here[size] = package[level][size] ? both : leaf[next].use;
            package[level][size] ? p++ : next++;
        }
    }
    memset(depth, 0, (size_t)n * sizeof *depth);
    for (int level = longest - 1, take = 2 * n - 2; level >= 0; level--) {
        int next = 0;
        for (int i = 0; i < take; i++)
            if (!package[level][i])
                depth[next++]++;
        take = 2 * (take - next);
    }
}

static uint16_t reversed(uint32_t code, int length)
{
    uint32_t r = 0;
    for (int i = 0; i < length; i++)
        r |= (code >> i & 1) << (length - 1 - i);
    return (uint16_t)r;
}

void encode_huffman_build(struct encode_huffman *h, const uint32_t *use,
                          int count, int longest)
{
    struct leaf leaf[ENCODE_HUFFMAN_MAX];
    int depth[ENCODE_HUFFMAN_MAX] = {0}, n = 0;
    assert(count >= 2 && count <= ENCODE_HUFFMAN_MAX);
    assert(longest <= 15 && 1 << longest >= count);
    memset(h, 0, sizeof *h);
    for (int s = 0; s < count; s++)
        if (use[s] > 0)
            leaf[n++] = (struct leaf){use[s], s};
    for (int s = 0; n < 2 && s < count; s++)
        if (use[s] == 0)
            leaf[n++] = (struct leaf){0, s};
    qsort(leaf, (size_t)n, sizeof *leaf, by_use);
    depths(leaf, n, depth);
    if (depth[0] > longest) // the rarest is the deepest
        limit(leaf, n, longest, depth);
    uint32_t per_length[16] = {0}, next[16] = {0};
    for (int i = 0; i < n; i++) {
        h->length[leaf[i].symbol] = (uint8_t)depth[i];
        per_length[depth[i]]++;
    }
    for (int l = 1; l < 16; l++)
        next[l] = (next[l - 1] + (l > 1 ? per_length[l - 1] : 0)) << 1;
    for (int s = 0; s < count; s++)
        if (h->length[s])
            h->code[s] = reversed(next[h->length[s]]++, h->length[s]);
}
