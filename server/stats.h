// stats.h - the reply to `stats`.
// Thread: loop.
#ifndef SERVER_STATS_H
#define SERVER_STATS_H

#include "protocol/json.h"
#include "server/hub.h"

// Adds its keys to an open object.
void stats_put(struct json *j, struct hub *h);

// The member "work": what was asked of the GPU (renderer/gl_count.h).
void stats_put_work(struct json *j, const struct gl_counts *w);

#endif
