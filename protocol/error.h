// error.h - how anything in Glint says that it failed.
//
// A function that can fail returns bool (or NULL) and takes `struct error *`
// as its last argument.  The error is set once, where the cause is known, with
// the thing, the value and the allowed range in its text; callers may put a
// prefix in front of it; the top reports it once.
// Thread: any (no shared state).
#ifndef PROTOCOL_ERROR_H
#define PROTOCOL_ERROR_H

#include <stdbool.h>

struct error {
    char code[16];  // "range", "syntax", "unknown", "file", "limit", "gpu", ...
    char name[64];  // the parameter, file or verb at fault; may be empty
    char text[320]; // one line, no newline, ready to be shown to a person
};

// Fills *err (NULL is allowed: the caller does not care) and returns false,
// so that a failing function ends with `return error_set(err, ...)`.
// Control characters in the result are replaced by blanks.
bool error_set(struct error *err, const char *code, const char *name,
               const char *fmt, ...) __attribute__((format(printf, 4, 5)));

// Puts "prefix: " in front of the text.  Always returns false.
bool error_prefix(struct error *err, const char *prefix);

#endif
