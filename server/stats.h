// stats.h - the reply to `stats`.
// Thread: loop.
#ifndef SERVER_STATS_H
#define SERVER_STATS_H

#include "protocol/json.h"
#include "server/hub.h"

// Adds its keys to an open object.
void stats_put(struct json *j, struct hub *h);

#endif
