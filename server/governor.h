// governor.h - what quality.budget_ms and quality.error come to: settings of
// the knobs, chosen from measured fronts (front.h).
//
// The time of a budget is that from an edit of the fibre to its first full
// frame; other kinds of edit may then take no longer than the budget or than by
// default, whichever is longer.  The error is that of the picture at rest: what
// `glintd bench` calls error, and what frames at rest report of themselves.
// A knob whose value is not its default is the user's, and stays.
//
// Chosen is the least error that the budget allows; or the least time that the
// error allows, time being the mean over the kinds of edit, relative to the
// default's.  The default is among the candidates: where it fits, what is
// chosen is never worse.  Times and errors of a front are scaled by what was
// measured here since. Thread: loop (values only).
#ifndef SERVER_GOVERNOR_H
#define SERVER_GOVERNOR_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/json.h"
#include "protocol/params.h"
#include "server/front.h"

// --- the choice --------------------------------------------------------------

enum governor_verdict {
    GOVERNOR_FITS,
    GOVERNOR_NEAREST, // nothing measured fits: the least time or error
    GOVERNOR_LATE,    // error and budget do not go together: the budget holds
    GOVERNOR_NONE     // nothing like this was measured: nothing is chosen
};

struct governor_ask {
    const struct front *front;   // NULL: there is none
    const struct params *params; // as they were set
    double time_ratio;           // measured / the front's
    double error_ratio;
};
struct governor_choice {
    enum governor_verdict verdict;
    int row, base; // of the front: what is chosen, and what the default comes
                   // to; < 0: none
};
// Is the knob the user's?  Its value is not the default; rays also where only a
// budget was set, for the first full frame is without them.
bool governor_pinned(const struct params *p, int knob);
// Pure.  With neither budget nor error, row is base.
struct governor_choice governor_choose(const struct governor_ask *ask);

// --- as it goes on -----------------------------------------------------------

enum { GOVERNOR_SEEN = 7, GOVERNOR_HOLD_US = 1000000 };

struct governor_ratio { // of the newest measurements
    double seen[GOVERNOR_SEEN];
    int count;
};

struct governor_note { // what was chosen; goes with a state to its frames
    char asked[64];    // "quality.budget_ms=50"; "": the governor is off
    char set[160];     // "sky.lights=20"; "": the default
    const char *why;
    // The front's figures times what was measured here; 0: not known.
    double expects_ms, expects_error, default_ms, default_error;
    double front_ms, front_error; // of the row, as the front has them
};

struct governor { // zero-initialised: off, without fronts
    struct fronts fronts;
    struct governor_ratio time, error;
    // Of the newest choice:
    const struct front *front;
    struct governor_choice choice;
    struct governor_note note;
    double key[12], used_time, used_error;
    char hair[65], env[65];
    int64_t edited_us;
};

void governor_finish(struct governor *g);

struct governor_state {
    const struct params *params; // as they were set
    struct front_scene scene;
    int64_t now_us;
};
// A new state: *out is what it comes to, with quality.budget_ms and .error 0,
// so that it can be drawn again without a governor; g->note says what was done.
// The choice is kept while edits follow one another within GOVERNOR_HOLD_US,
// and while what was measured since has moved little, unless budget, error, the
// user's knobs, the picture's size or the scene changed.
void governor_resolve(struct governor *g, const struct governor_state *state,
                      struct params *out);
// A first full frame of a state with this note took so long to shade, display
// and read; a picture at rest was found to be so wrong.
void governor_took(struct governor *g, const struct governor_note *note,
                   double ms);
void governor_judged(struct governor *g, const struct governor_note *note,
                     double error);

// "quality.budget_ms=50: sky.lights=20"; no figure that was measured is in it.
void governor_text(const struct governor_note *n, char *out, size_t room);
// Value of the key "governor" in a frame's header: that with the reason.
void governor_put_line(struct json *j, const struct governor_note *n);
// ... and in stats: an object, or null when it is off.
void governor_put(struct json *j, const struct governor *g);

#endif
