// verb_reference.h - pictures by reference.h for `glintd render --method`: no
// GPU is needed.
// Thread: main; uses all cores.
#ifndef SERVER_VERB_REFERENCE_H
#define SERVER_VERB_REFERENCE_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "renderer/fibre.h"
#include "server/options.h"

struct verb_reference {
    const char *method; // "reference-single", "reference-path"; NULL: neither
    enum fibre_model model;
    int samples, seed;
    bool progress; // on stderr even where it is no terminal
    bool verbose;
};

// An EXR, 32-bit float, into *out: R, G, B, A and variance.R, .G, .B, .A, the
// variance of each pixel's mean.  Refuses what reference_picture refuses.
bool verb_reference_run(const struct options *o,
                        const struct verb_reference *how, struct buf *out,
                        struct error *err);

#endif
