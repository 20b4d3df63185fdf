// frames_scene.h - the hair and the skies of frames.h.
#ifndef TESTS_EXTREMES_FRAMES_SCENE_H
#define TESTS_EXTREMES_FRAMES_SCENE_H

#include "protocol/params.h"
#include "renderer/groom.h"
#include "renderer/sky.h"
#include "tests/extremes/frames.h"

extern const char *const frames_hair_names[FRAMES_HAIRS];
extern const char *const frames_sky_names[FRAMES_SKIES];

// The caller's.
struct groom *frames_hair(int which);
struct sky_map *frames_sky(int which);

// What a hair or a sky wants to be seen with: a camera inside, one light or two
// hundred, a sun at the edge of the shadow.
void frames_adapt(struct params *p, int hair, int sky);

#endif
