// hub.h - what all clients share: the state with its revision, the engine, the
// newest frames, and who is to get them.
// Thread: loop.
#ifndef SERVER_HUB_H
#define SERVER_HUB_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/error.h"
#include "protocol/params.h"
#include "server/engine.h"
#include "server/loop.h"
#include "server/session.h"

enum {
    HUB_VIEWERS_MAX = STUDIO_DEMANDS,
    HUB_CAPTURES_MAX = 32,
    HUB_PATIENCE_S = 60 // of a capture that waits for a revision
};

struct hub_held { // the newest frame of an encoding
    struct studio_frame frame;
    uint64_t serial;
};

struct hub {
    struct loop *loop;
    struct engine *engine;
    const char *token;    // clients must give it; NULL: none
    struct params params; // as they were set
    struct params drawn;  // what the governor made of them
    struct governor governor;
    uint64_t revision;
    struct judge_verdict verdict; // of the newest picture that has one
    int64_t received_us;          // when its newest edit came in; 0: never
    struct engine_asset_info hair, env;
    struct session *sessions;
    int session_count, viewers, captures;
    struct hub_held held[STUDIO_DEMANDS];
    int held_count;
    uint64_t next_serial, next_frame, next_job;
    bool stopping;
    // Since the start
    int64_t started_us;
    uint64_t requests, refused, edits, frames_sent, bytes_sent;
    int connections; // kept by the listener
};

// engine: borrowed; its wake function must lead to hub_events.  fronts: taken.
void hub_init(struct hub *h, struct loop *loop, struct engine *engine,
              const struct params *p, const struct fronts *fronts);
void hub_finish(struct hub *h);

void hub_add(struct hub *h, struct session *s);
void hub_remove(struct hub *h, struct session *s);

// Fetches what the engine made and hands it on.
void hub_events(struct hub *h);
// A new state; the revision rises.
void hub_edit(struct hub *h, const struct params *p);
// Someone's credit, encoding or streaming changed: sends what is there and
// asks the engine for what is not.
void hub_serve(struct hub *h);

#endif
