// bench_cold.h - how long a daemon takes from its start to its first frame in a
// viewer's hands, in a process of its own.
// Thread: any that may wait.
#ifndef SERVER_BENCH_COLD_H
#define SERVER_BENCH_COLD_H

#include <stdbool.h>

#include "protocol/error.h"
#include "protocol/params.h"

struct bench_cold_ask {
    const char *hair, *env; // as options have them
    const struct params *params;
};

// Starts this program's `serve` on a free port of 127.0.0.1, asks for the
// stream, and ends it when the first frame (JPEG) is there whole: *ms from the
// start to its last byte.  Fails when there is none within a minute.
bool bench_cold_start(const struct bench_cold_ask *ask, double *ms,
                      struct error *err);

#endif
