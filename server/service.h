// service.h - what every connection of the daemon knows: the hub, the limits,
// and from which hosts and origins a browser may speak.
// Thread: loop.
#ifndef SERVER_SERVICE_H
#define SERVER_SERVICE_H

#include <stdbool.h>

#include "protocol/error.h"
#include "server/hub.h"
#include "server/loop.h"

enum {
    SERVICE_CONNECTIONS_MAX = 1024,
    SERVICE_NAMES_MAX = 16, // hosts that may be allowed
    SERVICE_DRAIN_S = 2     // at the end
};

struct conn;

struct service {
    struct loop *loop;
    struct hub *hub;
    int connections, connections_max;
    struct conn *conns;
    bool stopping;
    // "name:port" and "http://name:port", each ended by NULL; owned.
    char *hosts[SERVICE_NAMES_MAX + 1];
    char *origins[2 * SERVICE_NAMES_MAX + 1];
    int host_count, origin_count;
};

// A browser that was led to "name:port" may speak to us: Host is that, Origin
// is it behind http:// or https://.
bool service_allow(struct service *s, const char *host, struct error *err);
void service_finish(struct service *s);

#endif
