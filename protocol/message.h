// message.h - the two replies: {"ok":true,"tag":"7",...} and
// {"ok":false,"tag":"7","error":{"code":"range","name":"...","text":"..."}}.
// "tag" is left out when the request had none.
// Thread: any (no shared state).
#ifndef PROTOCOL_MESSAGE_H
#define PROTOCOL_MESSAGE_H

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/json.h"

// Opens the object of a good reply; the caller adds its keys and then calls
// message_end, which closes it and appends the "\n".
struct json message_ok(struct buf *out, struct span tag);
void message_end(struct json *j);

// A whole refusing reply, with its "\n".
void message_error(struct buf *out, struct span tag, const struct error *err);

#endif
