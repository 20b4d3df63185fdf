// schema.h - the parameter table told to others: to the page as JSON, to
// readers as Markdown, to a terminal as plain text.
// Thread: any (reads constants).
#ifndef PROTOCOL_SCHEMA_H
#define PROTOCOL_SCHEMA_H

#include "protocol/bytes.h"
#include "protocol/json.h"
#include "protocol/params.h"

// Writes one value, the array that the reply to `schema` has as "params":
// [{"name":"fibre.eta","group":"fibre","title":"Fibre","type":"float","unit":
// "","default":1.55,"min":1.05,"max":3,"choices":[],"auto":false,"doc":"..."}]
// type is one of float int bool choice rgb vec3.  default is a number, a
// boolean, a word, an array of three numbers, or "auto".  min and max are
// numbers, null where the type has none (bool, choice).
void schema_params(struct json *j);

// The value of one parameter in the shape that `default` has above.
void schema_value(struct json *j, const struct params *p,
                  const struct params_row *row);

// A Markdown table of all parameters, one heading per group.
void schema_markdown(struct buf *out);

// Plain text, 80 columns: one parameter in full; all, one line each.
void schema_help(struct buf *out, const struct params_row *row);
void schema_help_all(struct buf *out);

#endif
