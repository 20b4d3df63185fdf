// verbs.h - what `glint VERB` can do, and the options that the verbs share.
//
// A verb returns false with *err set; code "usage" means exit status 2, any
// other 1.
// Thread: main.
#ifndef PROTOCOL_CLIENT_VERBS_H
#define PROTOCOL_CLIENT_VERBS_H

#include <stdbool.h>
#include <stdint.h>

#include "protocol/client/reply.h"
#include "protocol/client/wire.h"
#include "protocol/error.h"

struct verbs_options {   // the command line, taken apart
    const char *connect; // HOST:PORT
    const char *unix_path;
    const char *token_file;
    const char *out;
    const char *timeout; // seconds, as text
    const char *count;
    bool json, help, markdown;
    int arg_count; // what follows the verb and is no option
    const char **args;
};

// Connects as the options say and, where a token is known (--token-file, or
// GLINT_TOKEN in the environment), says hello with it.  `patience` is the
// silence in seconds that --timeout changes; 0: no limit.
bool verbs_connect(struct wire *w, const struct verbs_options *o, int patience,
                   struct error *err);
// A whole number of an option, 1 .. max.
bool verbs_whole(const char *option, const char *text, uint64_t max,
                 uint64_t *out, struct error *err);

// Makes the folder of --out; nothing where there is none.
bool verbs_make_folder(const struct verbs_options *o, struct error *err);
// The bytes of a frame into a file of that folder, or away.
bool verbs_keep(const struct verbs_options *o, struct wire *w,
                const struct reply_frame *f, struct error *err);

bool verb_set_run(const struct verbs_options *o, struct error *err);
bool verb_get_run(const struct verbs_options *o, struct error *err);
bool verb_load_run(const struct verbs_options *o, struct error *err);
bool verb_capture_run(const struct verbs_options *o, struct error *err);
bool verb_watch_run(const struct verbs_options *o, struct error *err);
bool verb_send_run(const struct verbs_options *o, struct error *err);

#endif
