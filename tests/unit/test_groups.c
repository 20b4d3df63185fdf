// Lights as groups, for what other fibres scatter forward.
#include "tests/check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/light_groups.h"

enum { MANY = LIGHT_GROUPS_MAX };

static double unit(unsigned *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) / 16777216.0;
}

static void sky(struct light_groups_light *l, int count, unsigned seed)
{
    for (int i = 0; i < count; i++) {
        const double z = 2 * unit(&seed) - 1, a = 6.283185 * unit(&seed);
        const double r = sqrt(1 - z * z);
        l[i] = (struct light_groups_light){{r * cos(a), r * sin(a), z},
                                           0.05 + 0.3 * unit(&seed),
                                           pow(unit(&seed), 3)};
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// What is said of the groups, worked out from their members.
static void describes(const struct light_groups *g,
                      const struct light_groups_light *l)
{
    bool seen[MANY] = {false};
    double moved = 0, total = 0;
    int at = 0;
    for (int i = 0; i < g->count; i++) {
        const struct light_groups_group *group = &g->group[i];
        CHECK(group->first == at && group->end > at);
        double power = 0, apart = 0, width2 = 0;
        for (at = group->first; at < group->end; at++) {
            const struct light_groups_light *m = &l[g->member[at]];
            CHECK(!seen[g->member[at]]);
            seen[g->member[at]] = true;
            power += m->power;
            width2 += m->power * m->lambda * m->lambda;
            apart += m->power * (1 - dot(m->direction, group->direction));
        }
        CHECK_NEAR(dot(group->direction, group->direction), 1, 1e-12);
        CHECK_NEAR(group->power, power, 1e-12);
        // of the mean of 1 - cos from the centre, which rounding bounds
        CHECK_NEAR(group->lambda, sqrt((width2 + 2 * apart) / power), 1e-7);
        moved += 2 * apart;
        total += power;
    }
    CHECK(at == g->lights);
    // and what lobes of unlike width had to move within them
    CHECK(g->spread >= sqrt(fmax(moved, 0) / total) - 1e-7);
}

static void limits(void)
{
    struct light_groups_light l[MANY];
    struct light_groups *g = malloc(sizeof *g);
    sky(l, 40, 1);
    check_case("no spread, no groups");
    light_groups_make(g, l, 40, 0);
    CHECK(g->count == 40 && g->spread == 0);
    for (int i = 0; i < 40; i++) {
        CHECK(g->member[i] == i);
        CHECK_NEAR(g->group[i].lambda, l[i].lambda, 1e-7);
    }
    describes(g, l);
    check_case("groups are as described, within the spread");
    int before = 40;
    for (double spread = 0.02; spread < 2; spread *= 2) {
        light_groups_make(g, l, 40, spread);
        CHECK(g->spread <= spread && g->count <= before);
        before = g->count;
        describes(g, l);
    }
    CHECK(before < 5);
    check_case("no lights, no groups");
    light_groups_make(g, l, 0, 1);
    CHECK(g->count == 0 && g->spread == 0);
    check_case("as many as there may be, some without power");
    sky(l, MANY, 2);
    l[3].power = l[77].power = l[78].power = 0;
    light_groups_make(g, l, MANY, 0.1);
    CHECK(g->count < MANY && g->count > 10 && g->lights == MANY);
    for (int i = 0; i < g->count; i++)
        CHECK(isfinite(g->group[i].lambda) && g->group[i].lambda > 0);
    check_case("of two that face each other no light is lost");
    for (int i = 0; i < 2; i++)
        l[i] = (struct light_groups_light){{i ? -1 : 1, 0, 0}, 0.3, 2};
    light_groups_make(g, l, 2, 2);
    CHECK(g->count == 1 && g->group[0].power == 4);
    CHECK(dot(g->group[0].direction, g->group[0].direction) == 1);
    free(g);
}

// The same merges, found by looking at every pair each time.
static int by_force(const struct light_groups_light *l, int count,
                    double spread, int *root)
{
    double v[MANY][3], power[MANY], width2[MANY], total = 0, lost = 0;
    int left = count;
    for (int i = 0; i < count; i++) {
        root[i] = i;
        power[i] = l[i].power;
        total += power[i];
        width2[i] = power[i] * l[i].lambda * l[i].lambda;
        for (int k = 0; k < 3; k++)
            v[i][k] = power[i] * l[i].direction[k];
    }
    for (;;) {
        double best = INFINITY;
        int a = 0, b = 0;
        for (int i = 0; i < count; i++)
            for (int j = i + 1; j < count; j++) {
                if (root[i] != i || root[j] != j)
                    continue;
                const double sum[3] = {v[i][0] + v[j][0], v[i][1] + v[j][1],
                                       v[i][2] + v[j][2]};
                const double at_i = sqrt(dot(v[i], v[i]));
                const double at_j = sqrt(dot(v[j], v[j]));
                const double wide_i =
                    sqrt((width2[i] + 2 * (power[i] - at_i)) / power[i]);
                const double wide_j =
                    sqrt((width2[j] + 2 * (power[j] - at_j)) / power[j]);
                const double move = at_i + at_j - sqrt(dot(sum, sum)) +
                                    0.5 * power[i] * power[j] /
                                        (power[i] + power[j]) *
                                        pow(wide_i - wide_j, 2);
                if (move < best) {
                    best = move;
                    a = i;
                    b = j;
                }
            }
        if (left == 1 || 2 * (lost + best) > spread * spread * total)
            return left;
        lost += best;
        left--;
        for (int k = 0; k < 3; k++)
            v[a][k] += v[b][k];
        power[a] += power[b];
        width2[a] += width2[b];
        for (int i = 0; i < count; i++)
            if (root[i] == b)
                root[i] = a;
    }
}

static void forced(void)
{
    struct light_groups_light l[40];
    struct light_groups *g = malloc(sizeof *g);
    int root[MANY];
    check_case("the cheapest pair first, as by looking at all");
    for (unsigned seed = 0; seed < 20; seed++) {
        sky(l, 40, seed);
        const double spread = 0.05 + 0.02 * seed;
        light_groups_make(g, l, 40, spread);
        CHECK(by_force(l, 40, spread, root) == g->count);
        for (int i = 0; i < g->count; i++)
            for (int k = g->group[i].first; k < g->group[i].end; k++)
                CHECK(root[g->member[k]] == root[g->member[g->group[i].first]]);
    }
    free(g);
}

int main(void)
{
    limits();
    forced();
    return check_end();
}
