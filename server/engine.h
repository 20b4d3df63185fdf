// engine.h - where the loop thread and the render thread meet; nowhere else.
//
// The loop side posts the newest parameters (one place: latest wins), what
// viewers wait for, captures and things to load, and takes events.  Nothing
// here blocks the loop but the start and the end.  A third thread loads grooms
// and skies.
// Thread: loop, for every function here.
#ifndef SERVER_ENGINE_H
#define SERVER_ENGINE_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/renderer.h"
#include "server/assets.h"
#include "server/judge.h"
#include "server/loader.h"
#include "server/opening.h"
#include "server/studio.h"

struct engine;

struct engine_setup {
    const char *cache_dir;            // NULL keeps no fits
    struct params params;             // revision 1
    struct opening *opening;          // hair and sky; taken
    const struct assets_roots *roots; // borrowed until engine_destroy
    void (*wake)(void *ctx);          // called from other threads: events wait
    void *ctx;
};

// Starts the threads; returns when the renderer is there.  NULL when it cannot
// be had.
struct engine *engine_create(struct engine_setup *setup, struct error *err);
// Asks the threads to end and waits at most so long; false: still busy, and
// the engine must not be destroyed.
bool engine_stop(struct engine *e, int wait_ms);
void engine_destroy(struct engine *e); // NULL is allowed

// The newest state, as it is drawn, and what a governor chose of it.  Revisions
// rise.
void engine_edit(struct engine *e, const struct params *p,
                 const struct governor_note *note, uint64_t revision,
                 int64_t received_us);
// All that viewers with credit wait for; replaces what was asked before.
// viewers: how many clients stream at all; 0: nothing is rendered for them.
void engine_demand(struct engine *e, int viewers,
                   const struct studio_demand *demand, int count);

struct engine_capture {
    uint64_t id; // the caller's
    struct still_encoding how;
    int width, height; // 0: as the state says
};
// Renders the newest state to its end.  One event ENGINE_CAPTURED follows,
// unless it is cancelled.
void engine_capture(struct engine *e, const struct engine_capture *c);

// Loads and installs.  One event ENGINE_LOADED follows.
void engine_load(struct engine *e, uint64_t id, enum loader_asset which,
                 const char *name);
void engine_cancel(struct engine *e, uint64_t id); // a capture or a load

enum engine_event_type {
    ENGINE_FRAME,
    ENGINE_CAPTURED, // id, then frame or error
    ENGINE_LOADED,   // id, then asset or error
    ENGINE_FAILED,   // rendering for viewers: frame.revision, error
    ENGINE_JUDGED    // how wrong the picture at rest is: verdict
};

struct engine_asset_info {
    struct still_source source;
    uint32_t strands, points; // of a groom
    int width, height;        // of a sky
};

struct engine_event {
    enum engine_event_type type;
    uint64_t id;
    bool ok;
    enum loader_asset which;
    struct error error;
    struct studio_frame frame;
    struct engine_asset_info asset;
    struct judge_verdict verdict;
};
// The oldest waiting event, or false.  The caller then owns frame.bytes.  After
// an ENGINE_LOADED that is ok it calls engine_edit: what was loaded is of that
// revision, and nothing is rendered before.
bool engine_take(struct engine *e, struct engine_event *out);

struct engine_stats {
    struct renderer_stats renderer; // after the last step
    char device[128];
    struct engine_asset_info hair, env;
    uint64_t steps, cuts, drafts, frames, captures, coalesced, failures;
    int captures_waiting;
    struct judge_verdict verdict; // the newest; revision 0: none
    // Programs that the next edit may need (warmer.h): states rendered ahead,
    // and still to be; programs whose turn in the renderer is still to come.
    int warm_states, warm_states_left, warm_programs_left;
    bool warm;         // all that is one edit away is ready
    char progress[96]; // "" or what takes long just now
    double progress_seconds;
};
void engine_stats(struct engine *e, struct engine_stats *out);

#endif
