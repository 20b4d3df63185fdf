// watch.h - looked at between parts of long work: does something newer wait?
// Work that is cut leaves what it was to make unmade, and is begun again by who
// still wants it.
// Thread: any, while `newer` is any thread's.
#ifndef RENDERER_WATCH_H
#define RENDERER_WATCH_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

struct watch {                // zero-initialised: nothing is ever cut
    bool (*newer)(void *ctx); // NULL: nobody looks
    void *ctx;
    atomic_bool cut; // it was so: whoever looks from now on stops too
};

// Is the work to stop here?  NULL: it is not.
static inline bool watch_cut(struct watch *w)
{
    if (!w || !w->newer)
        return false;
    if (!atomic_load(&w->cut) && w->newer(w->ctx))
        atomic_store(&w->cut, true);
    return atomic_load(&w->cut);
}

#endif
