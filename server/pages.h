// pages.h - the web page's files, which the build puts into the binary.
// Thread: any (constants).
#ifndef SERVER_PAGES_H
#define SERVER_PAGES_H

#include <stdbool.h>

#include "protocol/bytes.h"

// The file served at `path` ("/", "/app.js"; without query or fragment).
// False when there is none; *body and *content_type are then unchanged.
bool pages_find(const char *path, struct span *body, const char **content_type);

#endif
