// json.h - writes JSON into a buffer, without blanks or line ends.  Glint
// never parses it, except for the few keys that the client looks for.
//
//   struct json j = json_begin(&buf);
//   json_open_object(&j);
//   json_key(&j, "ok"), json_bool(&j, true);
//   json_close_object(&j);
//
// Commas are put by the writer.  Closing what is not open, a value without a
// key in an object, or nesting deeper than JSON_DEPTH_MAX is a bug: asserted.
// Texts are UTF-8; a byte that is not valid UTF-8 is written as U+FFFD.
// Thread: any; an object belongs to one thread at a time.
#ifndef PROTOCOL_JSON_H
#define PROTOCOL_JSON_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"

#define JSON_DEPTH_MAX 16

struct json {
    struct buf *out; // borrowed
    int depth;
    bool key; // a key waits for its value
    bool object[JSON_DEPTH_MAX + 1];
    bool filled[JSON_DEPTH_MAX + 1]; // a comma is due before the next item
};

struct json json_begin(struct buf *out);
void json_open_object(struct json *j);
void json_close_object(struct json *j);
void json_open_array(struct json *j);
void json_close_array(struct json *j);
void json_key(struct json *j, const char *key);

void json_string(struct json *j, const char *text); // NULL: null
void json_span(struct json *j, struct span text);
void json_number(struct json *j, double value); // shortest; not finite: null
void json_float(struct json *j, float value);   // shortest for a float
void json_int(struct json *j, int64_t value);
void json_uint(struct json *j, uint64_t value);
void json_bool(struct json *j, bool value);
void json_null(struct json *j);
void json_raw(struct json *j, struct span text); // a value, JSON already

// Key and value in one.
void json_put_string(struct json *j, const char *key, const char *text);
void json_put_number(struct json *j, const char *key, double value);
void json_put_int(struct json *j, const char *key, int64_t value);
void json_put_bool(struct json *j, const char *key, bool value);

#endif
