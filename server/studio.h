// studio.h - the render thread's own room: the renderer, the live picture that
// viewers watch, and which moments of it are worth sending.  No lock and no
// socket; engine.c passes wishes in and frames out.
// Thread: render.
#ifndef SERVER_STUDIO_H
#define SERVER_STUDIO_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/params.h"
#include "renderer/renderer.h"
#include "server/assets.h"
#include "server/governor.h"
#include "server/haste.h"
#include "server/judge.h"
#include "server/opening.h"
#include "server/still.h"

enum {
    STUDIO_DEMANDS = 16,
    // In haste until so long after an edit: JPEG of an automatic stream,
    // drafts.
    STUDIO_HASTE_US = 300000,
    // After a draft the full picture waits for the hand to rest: as long as it
    // would take, at most so long, since it gives way to the next edit.
    STUDIO_REST_US = 80000,
    // Drafts made at rest after an edit, at most: more would be to and fro.
    STUDIO_REHEARSALS = 16,
    STUDIO_HASTE_QUALITY = 75, // 4:2:0
    STUDIO_REST_QUALITY = 90   // 4:4:4
};

// An encoding that a viewer with credit waits for, and the newest such frame
// that was made already.
struct studio_demand {
    struct still_encoding how; // quality 0: 75 4:2:0 in haste, 90 4:4:4 later
    uint64_t revision;         // 0: none yet
    int samples;
    bool final; // not told by samples: the last of them may be made anew
    bool hasty; // it was encoded in haste
};

struct studio_wish {
    struct params params;
    struct governor_note note; // what of them a governor chose
    uint64_t revision;         // from 1
    int64_t received_us;       // when its newest edit came in; 0: no edit yet
    int viewers;               // clients that stream, with credit or not
    struct studio_demand demand[STUDIO_DEMANDS];
    int demand_count;
};

struct studio_frame {
    struct blob *bytes; // owned by who has the frame
    struct still_encoding asked, used;
    uint64_t revision;
    int width, height, samples;
    bool final, hasty;
    struct renderer_draft
        draft;        // how this draft was made; divisor 0: it is none
    double render_ms; // rendering since the frame before
    double encode_ms;
    const char *path;                 // that drew it: a word of render.path
    double stage_ms[RENDERER_STAGES]; // < 0: did not run for this frame
    int64_t received_us;
    struct governor_note note;
    double
        first_ms; // of a first full frame: to shade, display and read; else 0
    struct judge_verdict verdict; // revision 0: none yet
};

struct studio {
    struct renderer *renderer;
    struct still_source hair, env;
    struct params set;         // what the renderer has
    struct governor_note note; // of it
    int samples;               // of `set`
    bool done;
    bool live;                   // `set` is the viewers' state of live_revision
    uint64_t live_revision;      // 0: none yet
    uint64_t failed_revision;    // of which a step failed; 0: none
    double render_ms;            // since the frame before
    bool stepped;                // since the frame before
    uint64_t steps;              // ever
    struct renderer_draft draft; // shown while samples is 0; divisor 0: none
    int64_t rest_us;             // after the edit: until then nothing but it
    uint64_t drafts;             // ever
    int rehearsals;              // that may follow, once there is a picture
    // Asked while something is made that no viewer waits for (renderer_watch).
    bool (*newer)(void *ctx);
    void *ctx;
    uint64_t cuts; // steps and rehearsals that were left for it, ever
    struct haste haste;
};

// Waits for groom and sky, and takes them, once there is a renderer.
bool studio_open(struct studio *s, const char *cache_dir, struct opening *o,
                 struct error *err);
void studio_close(struct studio *s);

bool studio_set_hair(struct studio *s, struct assets_hair *h,
                     struct error *err);
bool studio_set_sky(struct studio *s, struct assets_sky *m, struct error *err);

// Is there work for viewers at `now`?  If not, *until is the time at which to
// ask again, INT64_MAX: not before something changes.
bool studio_wants(const struct studio *s, const struct studio_wish *w,
                  int64_t now, int64_t *until);
// One turn of that work: a draft, or at most one step of rendering.
bool studio_turn(struct studio *s, const struct studio_wish *w,
                 struct error *err);
// Encodes for those demands that the picture as it stands would serve better;
// frames go into out[STUDIO_DEMANDS], *count of them.
bool studio_publish(struct studio *s, const struct studio_wish *w, int64_t now,
                    struct studio_frame *out, int *count, struct error *err);
// The frame serves this demand: it is remembered there.
void studio_served(struct studio_demand *d, const struct studio_frame *f);

// Does a final picture of the viewers' state stand still that is worth
// comparing with the truth?  (quality.error_places; all the light shown.)
bool studio_rests(const struct studio *s);
// Its places, for the judge; c->places is NULL on failure.
bool studio_case(struct studio *s, struct judge_case *c, struct error *err);

// A capture: begin, step until *done, end; leave, whatever came of it.  `p` may
// differ from the live state (another size); that then begins anew for the
// viewers.  layers: for an encoding with layers; refused where there are none.
void studio_capture_begin(struct studio *s, const struct params *p,
                          const struct studio_wish *w);
bool studio_capture_layers(struct studio *s, struct error *err);
void studio_capture_leave(struct studio *s);
bool studio_step(struct studio *s, bool *done, struct error *err);
bool studio_capture_end(struct studio *s, const struct still_encoding *how,
                        uint64_t revision, struct studio_frame *out,
                        struct error *err);

#endif
