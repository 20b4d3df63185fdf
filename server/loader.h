// loader.h - a thread that loads grooms and skies, one at a time, so that
// neither the loop nor the pictures wait for a file.
// Thread: any, for every function here; `done` is called on the loader's own.
#ifndef SERVER_LOADER_H
#define SERVER_LOADER_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "server/assets.h"

enum loader_asset { LOADER_HAIR, LOADER_ENV };

struct loader_item {
    struct loader_item *next;
    uint64_t id;
    enum loader_asset which;
    char *name;
    bool ok, cancelled;
    struct error error;      // when not ok
    struct assets_hair hair; // of LOADER_HAIR
    struct assets_sky sky;   // of LOADER_ENV
};
void loader_item_free(struct loader_item *item);

struct loader;

// done: takes the item over.  roots: borrowed.
struct loader *loader_create(const struct assets_roots *roots,
                             void (*done)(void *ctx, struct loader_item *item),
                             void *ctx, struct error *err);
void loader_add(struct loader *l, uint64_t id, enum loader_asset which,
                const char *name);
// One that waits is dropped; one being loaded comes with `cancelled` set.
void loader_cancel(struct loader *l, uint64_t id);
// Asks it to end; loader_ended says whether it has.
void loader_stop(struct loader *l);
bool loader_ended(struct loader *l);
// Joins: waits for a load that is under way.
void loader_destroy(struct loader *l); // NULL is allowed

#endif
