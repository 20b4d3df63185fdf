// events.h - what the render thread has to tell, in order.  A frame that nobody
// fetched yet gives way to a newer one of its kind.
// Thread: any; the caller keeps the lock.
#ifndef SERVER_EVENTS_H
#define SERVER_EVENTS_H

#include <stdbool.h>

#include "server/engine.h"

struct events { // zero-initialised is empty
    struct events_item *first, *last;
};

// Takes over frame.bytes.
void events_push(struct events *q, const struct engine_event *event);
// The oldest, or false.  The caller then owns frame.bytes.
bool events_take(struct events *q, struct engine_event *out);
// Frames that are on their way count as served.
void events_serve(const struct events *q, struct studio_demand *d);
void events_finish(struct events *q);

#endif
