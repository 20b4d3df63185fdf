// lights.h - what shines on the hair: the sky's SRBF lights turned into the
// world, those that cannot matter dropped, and the suns.
// Thread: render.
#ifndef RENDERER_LIGHTS_H
#define RENDERER_LIGHTS_H

#include "protocol/params.h"
#include "renderer/sky.h"

enum {
    LIGHTS_BINDING = 2, // of the uniform block
    LIGHTS_SUNS = 3,
    LIGHTS_MAX = SKY_LIGHTS_MAX // sky and suns together
};

// A sun is an SRBF light of this width (a ninth of a degree): narrower than
// every lobe of a fibre by far, wide enough for single precision.
#define LIGHTS_SUN_LAMBDA 0.002

struct lights_place {
    float direction[3], lambda; // world, unit; Xu width
    // 1, 2: holds less than a quarter, a sixteenth of what the fit's lights
    // hold on average, so that its shadows may be coarser; else 0
    int dim;
    float share; // of the fit's light, 1 on average; a sun's is 1
};

struct lights {
    unsigned block; // uniform buffer
    unsigned made;  // its number: no other content of any such block has it
    void *content;  // what is in it
    struct lights_place place[LIGHTS_MAX];
    int used, fitted, suns; // used: sky lights and suns; suns come last
    double dropped_share;   // of the sky's light, mean over channels
    float to_map[9];        // row-major: world direction -> map direction
    float tint[3];          // the block times this is what shines
    float radiance[LIGHTS_MAX][4]; // of the block; w: solid angle
};

// Map direction -> world direction, row-major.  Thread: any.
void lights_rotation(const struct params *p, double m[9]);

struct lights_sun {
    double direction[3];  // towards it, world, unit
    double irradiance[3]; // on a plane that faces it
};
// Those that shine; returns how many.  Thread: any.
int lights_suns(const struct params *p, struct lights_sun out[LIGHTS_SUNS]);

void lights_init(struct lights *l);
void lights_finish(struct lights *l);

// Where lights stand.  Rotation of the sky: roll about y, then pitch about x,
// then yaw about z (light.*).  Drops the dimmest sky lights while together they
// hold at most quality.light_bound of the sky's light.  True when any place,
// width or the count differs from before.
bool lights_put(struct lights *l, const struct sky_fit *fit,
                const struct params *p);
// How bright they are: the fit's radiances times tint.*, the suns' colours.
// apart: the sky's tint is kept apart, as the factor `tint`, which is one
// otherwise.  Uploads the block where it is another.  After lights_put.
void lights_tint(struct lights *l, const struct sky_fit *fit,
                 const struct params *p, bool apart);

#endif
