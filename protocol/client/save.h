// save.h - a file that appears whole or not at all: written beside its place
// under another name, renamed when complete, removed when not (also when the
// program is interrupted).
//
// "-" is the standard output.  A path at which something other than a regular
// file is (a device, a pipe) is written in place.
// Thread: main; one file at a time.
#ifndef PROTOCOL_CLIENT_SAVE_H
#define PROTOCOL_CLIENT_SAVE_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

struct save { // zero-initialised is closed
    int fd;
    char *path; // where it is to be
    char *temp; // where it is; NULL: in place
};

bool save_begin(struct save *s, const char *path, struct error *err);
bool save_write(struct save *s, struct span bytes, struct error *err);
// On failure nothing has appeared and *s is closed.
bool save_commit(struct save *s, struct error *err);
// Forgets what was written; a closed one is allowed.
void save_abort(struct save *s);

#endif
