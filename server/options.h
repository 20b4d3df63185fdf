// options.h - the command line: options that the verbs share, and a table by
// which a verb adds its own.
//
// Options are `--name value` or `--name=value`; `--` ends them.
// Thread: main.
#ifndef SERVER_OPTIONS_H
#define SERVER_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

#include "protocol/error.h"
#include "protocol/params.h"

// Shared options that a verb takes; any other one is refused.
enum {
    OPTIONS_HAIR = 1, // --hair FILE|builtin:NAME
    OPTIONS_ENV = 2,  // --env FILE|builtin:NAME
    OPTIONS_SET = 4,  // --set group.name=value, repeatable
    OPTIONS_SIZE = 8, // --size WxH, also --set image.width=, image.height=
    OPTIONS_OUT = 16, // --out FILE
    OPTIONS_SCENE = OPTIONS_HAIR | OPTIONS_ENV | OPTIONS_SET | OPTIONS_SIZE
};

struct options_list { // of borrowed texts, in order; zero-initialised is empty
    const char **item;
    int count;
};
void options_list_finish(struct options_list *l);

enum options_type {
    OPTIONS_FLAG, // bool *: no value
    OPTIONS_INT,  // int *: within [min, max]
    OPTIONS_REAL, // double *: within [min, max]
    OPTIONS_TEXT, // const char **: the text in argv
    OPTIONS_LIST  // struct options_list *: repeatable
};

struct options_row {  // an option of one verb; a table ends with name = NULL
    const char *name; // "listen", on the command line --listen
    enum options_type type;
    void *to;          // keeps what it holds when the option is not given
    double min, max;   // of OPTIONS_INT and OPTIONS_REAL
    const char *value; // "HOST:PORT" in the help; NULL for a flag
    const char *doc;
};

struct options_verb {
    const char *name;               // "render"
    const char *about;              // one line
    unsigned takes;                 // OPTIONS_HAIR | ...
    const struct options_row *rows; // own options, or NULL
    const char *args; // "[NAME=VALUE ...]" in the help; NULL: takes none
};

struct options {
    const char *hair; // "builtin:ponytail" unless given
    const char *env;  // "builtin:studio" unless given
    bool hair_given, env_given;
    const char *out;          // NULL unless given
    struct params params;     // defaults, then --set and --size in order
    struct options_list args; // words that are no options
};

// Parses argv[1..].  -1: go on.  Otherwise the status to exit with: 0 after
// --help (text on stdout), 2 after wrong usage (one line on stderr).
// The caller calls options_finish in every case.
int options_parse(struct options *o, const struct options_verb *verb, int argc,
                  char **argv);
void options_finish(struct options *o);

// Prints "glintd: TEXT" to stderr and returns 1.
int options_fail(const struct error *err);

#endif
