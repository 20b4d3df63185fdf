// bench_keep.h - arrays of doubles on disk under the digest of what made them.
// Thread: any; two processes may use one directory.
#ifndef SERVER_BENCH_KEEP_H
#define SERVER_BENCH_KEEP_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/digest.h"

struct bench_keep {
    const char *directory; // NULL: nothing is kept
    struct digest key;     // of everything that enters
};

// True when exactly `count` values were found, whole.
bool bench_keep_load(const struct bench_keep *k, double *values, size_t count);
// A directory that cannot be written is no error: then nothing is kept.
void bench_keep_save(const struct bench_keep *k, const double *values,
                     size_t count);

#endif
