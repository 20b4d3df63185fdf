// light_groups.c - puts lights together, the nearest and dimmest first (Ward's
// method on directions and widths weighted by power).
#include "renderer/light_groups.h"

#include <math.h>
#include <string.h>

struct cluster {
    double v[3];   // sum of power times direction
    double power;  // 0: part of another by now
    double width2; // sum of power times lambda^2
    int next;      // the nearest of those that come later, or -1
    double cost;   // of putting both together
    int root;      // the cluster that it went into, or itself
};

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// Of P = sum p_i with resultant V: sum p_i (1 - cos(angle to V)) = P - |V|.
static double apart(const struct cluster *c)
{
    return fmax(c->power - length(c->v), 0);
}

static struct cluster together(const struct cluster *a, const struct cluster *b)
{
    struct cluster c = *a;
    for (int i = 0; i < 3; i++)
        c.v[i] += b->v[i];
    c.power += b->power;
    c.width2 += b->width2;
    return c;
}

// Lobes exp(2 (cos - 1) / lambda^2) have a mean of 1 - cos of half lambda^2:
// the group's has that of all together.
static double width(const struct cluster *c)
{
    return sqrt((c->width2 + 2 * apart(c)) / c->power);
}

// Half the power times the square of how far it must move for both to be one:
// their centres to the common one, and the light of either within its lobe, for
// lobes of unlike width may share a centre (Wasserstein's distance of two round
// Gaussians: d^2 + (lambda_a - lambda_b)^2).
static double cost(const struct cluster *a, const struct cluster *b)
{
    const struct cluster both = together(a, b);
    const double wider = width(a) - width(b);
    return fmax(apart(&both) - apart(a) - apart(b), 0) +
           0.5 * a->power * b->power / both.power * wider * wider;
}

static void find_next(struct cluster *c, int count, int i)
{
    c[i].next = -1;
    c[i].cost = INFINITY;
    for (int j = i + 1; j < count; j++) {
        if (c[j].root != j)
            continue;
        const double move = cost(&c[i], &c[j]);
        if (move < c[i].cost) {
            c[i].cost = move;
            c[i].next = j;
        }
    }
}

// j goes into i.  Who had either as the nearest looks again; to others of those
// before it i may be nearer by now (find_next takes the first of equals).
static void merge(struct cluster *c, int count, int i, int j)
{
    c[i] = together(&c[i], &c[j]);
    c[j].root = i;
    for (int k = 0; k < j; k++) {
        if (c[k].root != k)
            continue;
        if (k == i || c[k].next == i || c[k].next == j) {
            find_next(c, count, k);
            continue;
        }
        const double move = k < i ? cost(&c[k], &c[i]) : INFINITY;
        if (move < c[k].cost || (move == c[k].cost && i < c[k].next)) {
            c[k].cost = move;
            c[k].next = i;
        }
    }
}

static int cheapest(const struct cluster *c, int count)
{
    int best = -1;
    for (int i = 0; i < count; i++)
        if (c[i].root == i && c[i].next >= 0 &&
            (best < 0 || c[i].cost < c[best].cost))
            best = i;
    return best;
}

static double merge_all(struct cluster *c, int count, double spread)
{
    double total = 0, lost = 0;
    for (int i = 0; i < count; i++)
        total += c[i].power;
    for (int i = 0; i < count; i++)
        find_next(c, count, i);
    // for small angles 1 - cos is half their square
    const double most = 0.5 * spread * spread * total;
    for (int i; (i = cheapest(c, count)) >= 0;) {
        if (!(spread > 0) || lost + c[i].cost > most)
            break;
        lost += c[i].cost;
        merge(c, count, i, c[i].next);
    }
    return total > 0 ? sqrt(2 * lost / total) : 0;
}

static void describe(struct light_groups_group *g, const struct cluster *c)
{
    const double n = length(c->v);
    for (int i = 0; i < 3; i++) // from all round: no centre is better
        g->direction[i] = n > 0 ? c->v[i] / n : i == 2;
    g->power = c->power;
    g->lambda = width(c);
}

void light_groups_make(struct light_groups *g,
                       const struct light_groups_light *light, int count,
                       double spread)
{
    const double least =
        1e-30; // a light without power has a place all the same
    struct cluster c[LIGHT_GROUPS_MAX];
    for (int i = 0; i < count; i++) {
        const struct light_groups_light *l = &light[i];
        c[i] = (struct cluster){.power = fmax(l->power, least), .root = i};
        for (int k = 0; k < 3; k++)
            c[i].v[k] = c[i].power * l->direction[k];
        c[i].width2 = c[i].power * l->lambda * l->lambda;
    }
    memset(g, 0, sizeof *g);
    g->lights = count;
    g->spread = merge_all(c, count, spread);
    int members = 0;
    for (int i = 0; i < count; i++) {
        if (c[i].root != i)
            continue;
        struct light_groups_group *out = &g->group[g->count++];
        describe(out, &c[i]);
        out->first = members;
        for (int j = 0; j < count; j++) {
            int root = j;
            while (c[root].root != root)
                root = c[root].root;
            if (root == i)
                g->member[members++] = j;
        }
        out->end = members;
    }
}
