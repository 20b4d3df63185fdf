// commands.h - the verbs of the protocol (protocol/PROTOCOL.md).
// Thread: loop.
#ifndef SERVER_COMMANDS_H
#define SERVER_COMMANDS_H

#include <stdbool.h>

#include "protocol/error.h"
#include "protocol/json.h"
#include "protocol/line.h"
#include "server/engine.h"
#include "server/session.h"

// Carries the request out and replies, or makes the session wait.  False: the
// caller replies with *err.
bool commands_run(struct session *s, const struct line *line,
                  struct error *err);

// Adds key "hair" or "env" with what is known of it.
void commands_put_asset(struct json *j, enum loader_asset which,
                        const struct engine_asset_info *info);

#endif
