// picture.h - a picture out of the renderer as the bytes of a file, with the
// state that made it.  Captures of the daemon and `glintd render` both go
// through here, so that the same state gives the same bytes.
// Thread: the renderer's.
#ifndef SERVER_PICTURE_H
#define SERVER_PICTURE_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/line.h"
#include "protocol/params.h"
#include "renderer/renderer.h"

// Order of the words of output.format, output.chroma and output.depth.
enum picture_format { PICTURE_JPEG, PICTURE_PNG, PICTURE_EXR };
enum picture_depth { PICTURE_HALF, PICTURE_FLOAT };

struct picture_encoding {
    int format;  // enum picture_format
    int quality; // JPEG, 1..100; 0: as the moment asks (streams only)
    int chroma;  // JPEG, enum encode_chroma
    int depth;   // EXR, enum picture_depth
};

// As output.* says.
struct picture_encoding picture_encoding_of(const struct params *p);
const char *picture_format_name(int format); // "jpeg"
bool picture_encoding_same(const struct picture_encoding *a,
                           const struct picture_encoding *b);

struct picture_source { // where a groom or a sky came from
    char name[64];      // file name without folders, or "builtin:studio"
    char sha256[65];    // hexadecimal
};

struct picture_state {           // all that determines the picture
    const struct params *params; // of the picture: image.* is its size
    struct picture_source hair, env;
    const char *device;
};

struct picture_request {
    const struct picture_state *state;
    struct picture_encoding how;
    bool with_state; // write the state into the file
    double read_ms, encode_ms; // out
};

// Reads the picture as it stands and encodes it, appending to *out.  The state
// goes into EXR attributes or PNG tEXt chunks: "glintd" (the version),
// "device", "hair", "hair_sha256", "env", "env_sha256", and each parameter by
// its name on the wire, as text that `set` takes.  JPEG holds none.
bool picture_encode(struct buf *out, struct renderer *r,
                    struct picture_request *request, struct error *err);

#endif
