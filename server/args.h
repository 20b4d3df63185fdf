// args.h - the words and pairs of a request as typed values, and the errors of
// both.
// Thread: any (values only).
#ifndef SERVER_ARGS_H
#define SERVER_ARGS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/line.h"
#include "server/still.h"

// For "%.*s": a span, cut to what an error text should quote.
#define ARGS_TEXT(s) \
    (int)((s).size > 60 ? 60 : (s).size), (const char *)(s).data

bool args_no_words(const struct line *line, struct error *err);
// Refuses a pair whose name is not in `names` (separated by blanks).
bool args_pairs(const struct line *line, const char *names, struct error *err);
// Both.
bool args_only(const struct line *line, const char *names, struct error *err);

// The pair `name` as a whole number within [min, max]; without it *to stays.
struct args_range {
    uint64_t min, max;
};
bool args_whole(const struct line *line, const char *name,
                struct args_range range, uint64_t *to, struct error *err);

// format= quality= chroma= depth= over what *how holds.
bool args_encoding(const struct line *line, struct still_encoding *how,
                   struct error *err);
// layers=on|off, which only an EXR has.
bool args_layers(const struct line *line, struct still_encoding *how,
                 struct error *err);

#endif
