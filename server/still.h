// still.h - a picture out of the renderer as the bytes of a file, with the
// state that made it.  Captures of the daemon and `glintd render` both go
// through here, so that the same state gives the same bytes.
// Thread: the renderer's.
#ifndef SERVER_STILL_H
#define SERVER_STILL_H

#include <stdbool.h>

#include "protocol/bytes.h"
#include "protocol/error.h"
#include "protocol/line.h"
#include "protocol/params.h"
#include "renderer/renderer.h"

// Order of the words of output.format, output.chroma and output.depth.
enum still_format { STILL_JPEG, STILL_PNG, STILL_EXR };
enum still_depth { STILL_HALF, STILL_FLOAT };

struct still_encoding {
    int format;  // enum still_format
    int quality; // JPEG, 1..100; 0: as the moment asks (streams only)
    int chroma;  // JPEG, enum encode_chroma
    int depth;   // EXR, enum still_depth
    bool layers; // EXR of a capture: the parts of the picture as well, which
                 // the renderer was told to make
};

// As output.* says.
struct still_encoding still_encoding_of(const struct params *p);
const char *still_format_name(int format); // "jpeg"
bool still_encoding_same(const struct still_encoding *a,
                         const struct still_encoding *b);

struct still_source { // where a groom or a sky came from
    char name[64];    // file name without folders, or "builtin:studio"
    char sha256[65];  // hexadecimal
};

struct still_state {             // all that determines the picture
    const struct params *params; // of the picture: image.* is its size
    struct still_source hair, env;
    const char *device;
    const char *governor; // what it chose of the parameters; NULL: off
};

struct still_request {
    const struct still_state *state;
    struct still_encoding how;
    bool with_state;           // write the state into the file
    double read_ms, encode_ms; // out
};

// Reads the picture as it stands and encodes it, appending to *out.  The state
// goes into EXR attributes or PNG tEXt chunks: "glintd" (the version),
// "device", "hair", "hair_sha256", "env", "env_sha256", "governor" where one
// chose, and each parameter by its name on the wire, as text that `set` takes.
// JPEG holds none.
bool still_encode(struct buf *out, struct renderer *r,
                  struct still_request *request, struct error *err);

// Pixels from elsewhere as EXR, float, with the state that made them: layers of
// image.*, names as encode.h has them.
struct encode_layer;
bool still_encode_layers(struct buf *out, const struct still_state *s,
                         const struct encode_layer *layers, int count,
                         struct error *err);

#endif
