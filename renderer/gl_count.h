// gl_count.h - how much was asked of the GPU: exact numbers, the same on every
// machine, where times are not.
// Thread: any; each counts for itself.
#ifndef RENDERER_GL_COUNT_H
#define RENDERER_GL_COUNT_H

#include <stdint.h>

struct gl_counts {
    uint64_t dispatches; // of compute shaders
    uint64_t draws;
    uint64_t uploads, upload_bytes; // into buffers and textures
    uint64_t reads, read_bytes;     // back, other than through mapped buffers
    uint64_t allocations;           // of buffers and textures
    uint64_t programs;              // linked
};

// Since the thread began.
struct gl_counts gl_count_now(void);
// What came after `from`.
struct gl_counts gl_count_since(const struct gl_counts *from);
// Puts functions that count between the callers of `gl` and the driver; of the
// functions as the driver has them.  Called by gl_load.
struct gl;
void gl_count_install(struct gl *table, const struct gl *driver);

#endif
