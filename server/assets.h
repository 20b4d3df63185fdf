// assets.h - grooms and skies from where they are named: built in, a path of
// who runs the program, or a file below a directory that clients may use.
// Loading takes up to seconds.
// Thread: any; an object belongs to one thread at a time.
#ifndef SERVER_ASSETS_H
#define SERVER_ASSETS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "renderer/groom.h"
#include "renderer/sky.h"
#include "server/still.h"

// Directories below which clients may name files.
struct assets_roots { // zero-initialised: none
    struct assets_root *item;
    int count;
};
bool assets_roots_add(struct assets_roots *roots, const char *path,
                      struct error *err); // opens the directory
void assets_roots_finish(struct assets_roots *roots);

struct assets_hair {
    struct groom *groom;
    struct still_source source;
    uint32_t strands, points;
};
struct assets_sky {
    struct sky_map *map;
    struct still_source source;
    int width, height;
};

// roots == NULL: `name` is "builtin:NAME" or any path.  Otherwise
// "builtin:NAME" or a path below one of the roots: relative to it, or beginning
// with the root's own path; symbolic links that lead out of it are refused.
bool assets_hair_load(struct assets_hair *h, const char *name,
                      const struct assets_roots *roots, struct error *err);
bool assets_sky_load(struct assets_sky *s, const char *name,
                     const struct assets_roots *roots, struct error *err);
void assets_hair_finish(struct assets_hair *h);
void assets_sky_finish(struct assets_sky *s);

#endif
