// find.h - looks values up in a line of JSON that glintd wrote (protocol/
// json.h: no blanks between tokens).  This is no validator: of text that is not
// such JSON it may say anything, but it never reads beyond the span.
// Thread: any (no shared state).
#ifndef PROTOCOL_CLIENT_FIND_H
#define PROTOCOL_CLIENT_FIND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"

// The value of `key` in an object, as JSON text; strings keep their quotes.
bool find_key(struct span object, const char *key, struct span *value);

// The next member of an object, from *at on (0 at first).  The key is without
// its quotes, escapes as they stand.
bool find_member(struct span object, size_t *at, struct span *key,
                 struct span *value);
// The next item of an array, from *at on (0 at first).
bool find_item(struct span array, size_t *at, struct span *value);

// The value of a key of that type.
bool find_u64(struct span object, const char *key, uint64_t *out);
bool find_number(struct span object, const char *key, double *out);
bool find_bool(struct span object, const char *key, bool *out);

// Appends a JSON string, given with its quotes, as plain text.  False when it
// is no string; control characters become blanks, so that a terminal may have
// the result.
bool find_text(struct span value, struct buf *out);

#endif
