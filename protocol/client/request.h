// request.h - builds request lines (protocol/line.h) out of command-line words.
// Thread: main.
#ifndef PROTOCOL_CLIENT_REQUEST_H
#define PROTOCOL_CLIENT_REQUEST_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

// Starts a line with a verb; what *out held is forgotten.
void request_begin(struct buf *out, const char *verb);
// A positional word, as it stands.
void request_word(struct buf *out, const char *word);
// name=value from "name=value"; the value is put in quotes where it must be.
bool request_pair(struct buf *out, const char *assignment, struct error *err);
void request_value(struct buf *out, const char *name, const char *value);
// Ends the line, and checks that the daemon will be able to read it.
bool request_end(struct buf *out, struct error *err);

// The name in "name=value" has a point: a parameter, not an option of a verb.
bool request_is_parameter(const char *assignment);

#endif
