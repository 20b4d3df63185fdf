// line.h - one request of the line protocol.
//
//   line  = ["#" tag " "] verb *(" " word) *(" " name "=" value)
//   tag   = 1*64 of [A-Za-z0-9_.:-]
//   verb  = [a-z][a-z0-9_.]*          at most 64 bytes
//   name  = [a-z][a-z0-9_.]*          at most 64 bytes
//   word  = 1*  of what is neither blank, control, `"` nor "="
//   value = word that may hold "=" / `"` *(char / escape) `"`
//   escape = `\\`, `\"`, `\n`, `\uXXXX` (pairs of surrogates make one
//            character; a lone surrogate and \u0000 are refused)
//
// One blank separates; there is none before or after.  A token in which "="
// comes before any `"` is a pair; after the first pair no word may follow.  An
// unquoted value is not empty (`""` is), a backslash in it is itself.  A name
// given twice is refused.  Control characters (tab too) appear only as escapes.
// A line ends with "\n"; a "\r" just before it is dropped.
// Thread: any; an object belongs to one thread at a time.
#ifndef PROTOCOL_LINE_H
#define PROTOCOL_LINE_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

#define LINE_BYTES_MAX 65536 // without the "\n"
#define LINE_WORDS_MAX 128
#define LINE_PAIRS_MAX 128
#define LINE_TAG_MAX 64
#define LINE_NAME_MAX 64

struct line_pair {
    struct span name;
    struct span value; // unquoted
    bool quoted;       // it was in quotes
};

// About 7 KiB: on the stack for one request, not one per client.
struct line {        // zero-initialised is empty
    struct span tag; // without "#"; size 0: there was none
    struct span verb;
    int word_count, pair_count;
    struct span words[LINE_WORDS_MAX];
    struct line_pair pairs[LINE_PAIRS_MAX];
    struct buf store; // own: unquoted values
};

// Takes one line apart.  `text` has no line end and must outlive *line, whose
// spans point into it or into line->store.  On failure err->code is "syntax",
// or "limit" where a count or a length is exceeded; tag and verb are filled as
// far as they could be read, so that the reply can carry the tag.  *line may
// be reused for the next line without line_finish.
bool line_parse(struct line *line, struct span text, struct error *err);
void line_finish(struct line *line);

// The value of pair `name`, or NULL.
const struct line_pair *line_pair(const struct line *line, const char *name);
// text equals the C string.
bool line_is(struct span text, const char *word);

enum line_result { LINE_MORE, LINE_ONE, LINE_BAD };

// Cuts the first line out of a stream.  `in` is all that was received and not
// yet used; *scanned is 0 before the first call, and a memory of it between
// calls while bytes are only appended.  LINE_ONE: *line is it, without its end;
// *used bytes belong to it; *scanned is 0 again.  LINE_BAD: the stream cannot
// be trusted any more and is to be closed: the line is longer than
// LINE_BYTES_MAX (code "limit"), or it begins like HTTP (code "http",
// line_looks_http), which is noticed before its end has come.
enum line_result line_cut(struct span in, size_t *scanned, struct span *line,
                          size_t *used, struct error *err);

// First bytes of a connection, or of a line: LINE_ONE: a word of 1 to 32 upper
// case letters and a blank, as HTTP begins; LINE_BAD: certainly not;
// LINE_MORE: not to be told yet.
enum line_result line_looks_http(struct span first);

#endif
