// light_groups.h - lights that stand near each other as one, for what other
// fibres scatter forward: that light comes from a wide cone (Zinke 2008, eq 8;
// sigma_f), in which it can hardly be told where in a few degrees it began.
// What of a group comes through the hair is the mean of its lights'
// transmittances by power, which is exact where they are of one colour.
// Approximate is where it comes from: one lobe at the power's centre, as wide
// as all of them together. Thread: any.
#ifndef RENDERER_LIGHT_GROUPS_H
#define RENDERER_LIGHT_GROUPS_H

enum { LIGHT_GROUPS_MAX = 200 };

struct light_groups_light {
    double direction[3], lambda, power; // unit; Xu width; any unit
};

struct light_groups_group {
    double direction[3], lambda, power;
    int first, end; // of `member`
};

struct light_groups {
    int lights, count;
    double spread; // what merging moved the light by, rms, rad
    struct light_groups_group group[LIGHT_GROUPS_MAX];
    int member[LIGHT_GROUPS_MAX]; // the lights, group by group
};

// Pairs are put together, those first that move the least light, while `spread`
// stays below this (0: each light is a group).  count: 0 to LIGHT_GROUPS_MAX.
// The same lights give the same groups, wherever the sky is turned, as long as
// directions come in its own frame.
void light_groups_make(struct light_groups *g,
                       const struct light_groups_light *light, int count,
                       double spread);

#endif
