// crew.h - short work in pieces, on threads that are there already: what an
// edit asks for takes less than starting one would.  (shoot_threads.h starts
// its own, for work that takes longer.)
//
// One crew for the whole process, as many as it may use cores.  Who asks while
// another works with it works alone, and so does a thread of lower priority
// than the crew's, which is that of the thread that started it.
// Thread: any; the caller works too, and returns when all is done.
#ifndef RENDERER_CREW_H
#define RENDERER_CREW_H

#include <stddef.h>

// Starts the crew where it is not yet; crew_run does, too.
void crew_start(void);

// work(context, i) once for each i below count, in no order: what a piece makes
// must depend on nothing that another one of these makes.
void crew_run(size_t count, void (*work)(void *context, size_t i),
              void *context);

// Cores that this process may use, so that a container's or taskset's limit
// holds; 64 at most.
int crew_cores(void);

// For tests: at most so many threads from now on, the caller's among them; 0:
// as many as there are cores.
void crew_limit(int threads);

#endif
