// sky_cache.h - fits kept on disk, one small file each.
//
// A file is written beside its place and renamed, so a reader sees a whole one
// or none, whoever else writes.  What is read is checked to the last bit; a
// file that fails is ignored and later replaced.
// Thread: any; several processes may share a folder.
#ifndef RENDERER_SKY_CACHE_H
#define RENDERER_SKY_CACHE_H

#include "renderer/sky.h"

struct sky_cache_key {
    unsigned char sha256[32]; // of the sky
    int lights;
    enum sky_fit_mode mode;
};

// Fills *fit (from_cache set) or leaves it zeroed and returns false.
bool sky_cache_read(const char *dir, const struct sky_cache_key *key,
                    struct sky_fit *fit);
// Does nothing where the folder cannot be made or written.
void sky_cache_write(const char *dir, const struct sky_cache_key *key,
                     const struct sky_fit *fit);

#endif
