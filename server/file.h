// file.h - a result into a file: whole or not at all.
// Thread: any.
#ifndef SERVER_FILE_H
#define SERVER_FILE_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

// Writes a file beside `path` and renames it when it is complete.
bool file_write(const char *path, const struct buf *bytes, struct error *err);

#endif
