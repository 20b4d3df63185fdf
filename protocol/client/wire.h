// wire.h - the connection to a daemon: lines out, lines and frames in.
// Thread: main.
#ifndef PROTOCOL_CLIENT_WIRE_H
#define PROTOCOL_CLIENT_WIRE_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/client/save.h"
#include "protocol/error.h"

#define WIRE_ADDRESS "127.0.0.1:8177"
#define WIRE_LINE_MAX (4u << 20)  // bytes of a line that the daemon sends
#define WIRE_BYTES_MAX (1u << 30) // bytes of a frame
#define WIRE_CONNECT_MS 10000

struct wire { // zero-initialised is closed
    int fd;
    int timeout_ms; // longest silence while something is awaited; -1: no limit
    struct buf in;
    size_t at, scanned; // used bytes of `in`; those without a line end
};

// To the Unix socket `path`, or when that is NULL to "HOST:PORT" (an IPv6
// address in brackets).  A failure names the place and what to do.
bool wire_open(struct wire *w, const char *address, const char *path,
               struct error *err);
void wire_close(struct wire *w);

bool wire_send(struct wire *w, struct span bytes, struct error *err);

// The next line, without its end; valid until the next call.
bool wire_line(struct wire *w, struct span *line, struct error *err);
// The same if it has come whole already; does not wait.
bool wire_ready(struct wire *w, struct span *line);
// Waits for bytes and takes them in.
bool wire_fill(struct wire *w, struct error *err);

// The next `size` bytes into *to, or away when it is NULL.
bool wire_bytes(struct wire *w, uint64_t size, struct save *to,
                struct error *err);

#endif
