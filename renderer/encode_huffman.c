// encode_huffman.c - lengths by the two-queue method on sorted counts, then
// shortened to the limit by moving leaves, then canonical codes.
#include "renderer/encode_huffman.h"

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

// Cuts depths to `longest` and mends the Kraft sum to exactly one: while it is
// too large, the deepest leaf above the limit goes one level down.
static void limit(int *depth, int n, int longest)
{
    int64_t sum = 0, full = (int64_t)1 << longest;
    for (int i = 0; i < n; i++) {
        if (depth[i] > longest)
            depth[i] = longest;
        sum += full >> depth[i];
    }
    // rarest first: they are the cheapest to lengthen
    while (sum > full)
        for (int level = longest - 1; level > 0 && sum > full; level--) {
            int i = 0;
            while (i < n && depth[i] != level)
                i++;
            if (i == n)
                continue;
            depth[i]++;
            sum -= full >> depth[i];
            break;
        }
    // a step may have gone too far: give what is free to the commonest
    for (int i = n - 1; i >= 0 && sum < full; i--)
        if (depth[i] == longest) {
            depth[i]--;
            sum++;
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
    int depth[ENCODE_HUFFMAN_MAX], n = 0;
    memset(h, 0, sizeof *h);
    for (int s = 0; s < count; s++)
        if (use[s] > 0)
            leaf[n++] = (struct leaf){use[s], s};
    for (int s = 0; n < 2 && s < count; s++)
        if (use[s] == 0)
            leaf[n++] = (struct leaf){0, s};
    qsort(leaf, (size_t)n, sizeof *leaf, by_use);
    depths(leaf, n, depth);
    limit(depth, n, longest);
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
