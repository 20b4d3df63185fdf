// guards.h - names and remarks of the guards of shaders/guard.glsl, read from
// the text that is built into the program.
#ifndef TESTS_EXTREMES_GUARDS_H
#define TESTS_EXTREMES_GUARDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "renderer/probe.h"

enum { GUARDS_MAX = 32 * PROBE_GUARD_WORDS };

struct guards_row {
    char name[40], what[96]; // empty where there is no such guard
};

// Reads them once; false when the text is not what it should be.
bool guards_read(struct guards_row row[GUARDS_MAX]);

static inline bool guards_hit(const uint32_t *hits, int guard)
{
    return hits[guard / 32] >> (guard % 32) & 1;
}

// Adds the cases of hits[count][PROBE_GUARD_WORDS] that hit each guard.
void guards_count(const uint32_t *hits, size_t count, long sum[GUARDS_MAX]);

#endif
