// conn.h - one connection: bytes in, bytes out, patience.
//
// What is spoken is told from the first bytes: HTTP (which may become a
// WebSocket) or the line protocol.  Reading stops while the session waits or
// replies pile up; nothing is queued without bound.
// Thread: loop.
#ifndef SERVER_CONN_H
#define SERVER_CONN_H

#include <stdbool.h>

#include "server/service.h"

struct conn;

// Takes the socket.  trusted: no token is asked of it.
void conn_open(struct service *s, int fd, bool trusted);
// The daemon ends: says good-bye and closes once all is written.
void conn_good_bye(struct conn *c);
struct conn *conn_next(const struct conn *c); // in service.conns
// Ends at once.
void conn_destroy(struct conn *c);

#endif
