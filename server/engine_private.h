// engine_private.h - the engine's inside, shared by its two files: engine.c
// (the loop's side, start and end) and engine_render.c (the render thread).
#ifndef SERVER_ENGINE_PRIVATE_H
#define SERVER_ENGINE_PRIVATE_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#include "server/engine.h"
#include "server/events.h"
#include "server/warmer.h"

struct capture_item {
    struct capture_item *next;
    struct engine_capture capture;
};

// What was installed belongs to the revision that the loop makes of it: until
// that is known nothing is rendered, or a frame would name the one before.
enum installed { SETTLED, INSTALLED, TAKEN };

struct engine {
    pthread_t render;
    bool started; // the render thread runs
    struct loader *loader;
    struct judge *judge;
    struct warmer *warmer; // NULL: told not to
    pthread_mutex_t lock;
    pthread_cond_t work;   // for the render thread
    pthread_cond_t change; // start, end, for the loop; installed, the loader
    void (*wake)(void *ctx);
    void *ctx;
    struct engine_setup *setup; // during the start only

    // Under the lock:
    bool stop, ready, ended;
    struct error start_error;
    struct studio_wish wish;
    uint64_t taken_revision; // newest that was rendered
    bool viewers_next;       // after a capture viewers have their turn
    struct capture_item *captures;
    uint64_t capturing; // id of the running one; 0: none
    bool capture_cancelled;
    struct loader_item *loaded; // waiting to be installed
    enum installed installed;
    struct events events;
    struct engine_stats stats;
    int64_t progress_since;
    struct buf names; // of programs that the warmer needed, a line each
    size_t names_at;  // before it the renderer has them
    // Render thread only:
    uint64_t judged; // the newest revision that the judge was asked about
    struct params judged_params; // its state
    uint64_t warmed; // the newest revision that the warmer was asked about
    struct studio studio;
};

void *engine_render_main(void *engine); // the render thread
// False when the time `until` (clock_us) has come.
bool engine_render_wait(struct engine *e, pthread_cond_t *cond, int64_t until);

#endif
