// opening.h - groom and sky of the start, each loaded on a thread of its own
// while the renderer comes up.
// Thread: any one.
#ifndef SERVER_OPENING_H
#define SERVER_OPENING_H

#include <stdbool.h>

#include "protocol/error.h"
#include "server/assets.h"

struct opening;

// The names are those of who runs the program (assets.h); copied.
struct opening *opening_begin(const char *hair, const char *sky);
// Waits for both.  Of two errors the hair's.  Then there is neither.
bool opening_wait(struct opening *o, struct error *err);
// After opening_wait; whoever takes one out leaves NULL in its place.
struct assets_hair *opening_hair(struct opening *o);
struct assets_sky *opening_sky(struct opening *o);
void opening_end(struct opening *o); // waits too; NULL is allowed

#endif
