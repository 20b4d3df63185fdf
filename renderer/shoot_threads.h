// shoot_threads.h - the same work for many items, on all cores.
// Thread: any; the caller works too, and waits for the others.
#ifndef RENDERER_SHOOT_THREADS_H
#define RENDERER_SHOOT_THREADS_H

#include <stddef.h>

// work(context, i) once for each i below count, in no order, on as many
// threads as this process may use cores.
void shoot_threads(size_t count, void (*work)(void *context, size_t i),
                   void *context);

#endif
