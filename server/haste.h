// haste.h - how coarse a draft has to be for the time that it may take, going
// by what full first samples and earlier drafts took on this machine.  Thread:
// render (values only).
#ifndef SERVER_HASTE_H
#define SERVER_HASTE_H

#include <stdbool.h>

#include "renderer/renderer.h"

enum { HASTE_KINDS = 8 };

struct haste {       // zero-initialised: nothing is known
    double visible;  // ms, of all strands
    double tail;     // ms from the picture to bytes, of a full frame
    double own_tail; // ... and of a draft
    double seen;     // ms, of the newest draft's raster; 0: none with `stride`
    double budget;   // ms, of the newest choice
    int stride;      // in use; it changes seldom: strands are built anew
    int least;       // that it has to be
    int late, early; // drafts in a row with a long, with a short raster
    struct haste_kind {
        int divisor;     // of the newest draft; 0: none yet
        int times;       // drafts in a row of this size, 0 to 255
        double pixels;   // ms of shadow and shading, times divisor^2
        double field;    // ms of the coarse field
        double strands;  // ms of making the strands, times stride
    } kind[HASTE_KINDS]; // by which stages the edit asks for
};

struct haste_ask {
    double budget_ms;
    int height;          // of the whole picture
    double width_pixels; // how wide a strand is in it
    // Drafts that need no raster (renderer_drafts_seen).
    struct renderer_draft seen[RENDERER_DRAFT_VIEWS];
    int seen_count;
    bool resting; // there is time for a raster of all strands beforehand
};

// A full first sample was made; stage_ms as in renderer_stats.
void haste_full(struct haste *h, const double *stage_ms);
// It was displayed and encoded in so many ms.
void haste_full_tail(struct haste *h, double ms);
// Is a draft to be made of what is forecast (renderer_forecast), and which?
// False where the full sample itself takes at most budget_ms.
bool haste_choose(struct haste *h, const double *forecast,
                  const struct haste_ask *ask, struct renderer_draft *how);
// That draft was made.
void haste_draft(struct haste *h, const double *forecast,
                 const struct renderer_draft *how, const double *stage_ms);
void haste_draft_tail(struct haste *h, double ms);
// Has the size of such drafts settled, so that `how` is what the next one will
// be like?
bool haste_settled(const struct haste *h, const double *forecast,
                   const struct renderer_draft *how);
// Of a forecast: all its stages, display and encoding.
double haste_full_ms(const struct haste *h, const double *forecast);

#endif
