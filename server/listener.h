// listener.h - sockets that wait for connections.
// Thread: loop.
#ifndef SERVER_LISTENER_H
#define SERVER_LISTENER_H

#include <stdbool.h>

#include "protocol/error.h"
#include "server/loop.h"
#include "server/service.h"

struct listener;

// "HOST:PORT"; HOST is an IPv4 address, an IPv6 address in brackets, or
// "localhost".  Port 0 takes a free one.  any_address: an address that other
// machines can reach is allowed (the caller asks for a token then).
struct listener_address {
    const char *text;
    bool any_address;
};
struct listener *listener_tcp(struct service *s, struct listener_address a,
                              struct error *err);
// A Unix socket, for this user only.  A stale file that nobody listens on is
// replaced.
struct listener *listener_unix(struct service *s, const char *path,
                               struct error *err);
// "127.0.0.1:8177" as bound, or the path.
const char *listener_name(const struct listener *l);
int listener_port(const struct listener *l); // 0 of a Unix socket
void listener_destroy(struct listener *l);   // NULL is allowed

#endif
