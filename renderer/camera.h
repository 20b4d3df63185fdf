// camera.h - the pinhole camera: what `auto` means, and the matrices.
// World: right-handed, z up.  Depth is reversed (1 near, 0 at infinity).
// Thread: any; values only.
#ifndef RENDERER_CAMERA_H
#define RENDERER_CAMERA_H

#include "protocol/params.h"

struct camera {
    float eye[3], target[3];
    float right[3], up[3], forward[3]; // unit, orthogonal
    float tan_half;                    // of the vertical field of view
    float near;                        // distance of the near plane
    float view_proj[16];               // column-major, to clip space
};

// box: of everything that is to be in view, world.  `auto` eye looks from -y.
void camera_resolve(const struct params *p, const float box_min[3],
                    const float box_max[3], struct camera *c);

#endif
