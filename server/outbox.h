// outbox.h - what waits to be written to one connection: small bytes of its
// own, and blobs shared with others, in order.
//
// Nothing is bounded here by itself: who fills it looks at `replies` and
// `blobs` first (see conn.h).
// Thread: loop.
#ifndef SERVER_OUTBOX_H
#define SERVER_OUTBOX_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/bytes.h"

struct outbox_item;

struct outbox { // zero-initialised is empty
    struct outbox_item *first, *last;
    size_t offset;  // of `first`, already written
    size_t replies; // bytes that are not in blobs, not yet written
    int blobs;      // blobs not yet wholly written
};

void outbox_finish(struct outbox *o);
bool outbox_empty(const struct outbox *o);
void outbox_bytes(struct outbox *o, const void *data, size_t size);
void outbox_blob(struct outbox *o, struct blob *b); // takes a new reference

enum outbox_result {
    OUTBOX_DONE,    // empty now
    OUTBOX_BLOCKED, // the socket takes no more for now
    OUTBOX_BROKEN   // the peer is gone
};
// Writes without blocking.  *wrote is how many bytes the socket took.
enum outbox_result outbox_write(struct outbox *o, int fd, size_t *wrote);

#endif
