// sky_helper.h - decoding in a process that may crash or be killed.
//
// The program that runs is this one, executed anew (/proc/self/exe), which
// sky_helper_main (sky.h) recognises by its argv.  It gets a sealed copy of the
// file, an empty file for the pixels and a pipe for its report, and nothing
// else; its memory, CPU time and output are limited.
#ifndef RENDERER_SKY_HELPER_H
#define RENDERER_SKY_HELPER_H

#include "renderer/sky_pixels.h"

enum { SKY_HELPER_SECONDS = 5 }; // of wall clock, enforced by the parent

// argv[0] of the helper.
extern const char *const sky_helper_name;

// Decodes the file that fd (a memfd; borrowed) holds.
// Fails: what the readers refuse; a crash, a hang or a kill of the helper.
// Thread: any, of a process with any threads; blocks up to the time above.
bool sky_helper_decode(int fd, struct sky_pixels *out, struct error *err);

#endif
