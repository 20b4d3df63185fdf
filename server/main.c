// main.c - hands the command line to a verb.
#include <stdio.h>
#include <string.h>

#include "renderer/sky.h"
#include "server/verbs.h"
#include "server/version.h"

static const struct verb {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *about;
} verbs[] = {
    {"serve", verb_serve_run, "show the picture to browsers and scripts"},
    {"render", verb_render_run, "one picture into a file"},
    {"probe", verb_probe_run, "single scattering integrals, as numbers"},
    {"bench", verb_bench_run, "error against run time, of every setting"},
    {"fit", verb_fit_run, "the lights that stand for a sky"},
    {"info", verb_info_run, "device, built-in grooms, parameters, files"},
};
enum { VERBS = sizeof verbs / sizeof verbs[0] };

static void help(void)
{
    printf("usage: glintd [VERB] [OPTION ...]\n\n"
           "Hair in the light of a whole sky, while you edit it.\n\n");
    for (int v = 0; v < VERBS; v++)
        printf("  %-8s %s%s\n", verbs[v].name, verbs[v].about,
               v == 0 ? " (default)" : "");
    printf("\n`glintd VERB --help` lists a verb's options.\n");
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    if (argc < 2)
        return verb_serve_run(argc, argv);
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        help();
        return 0;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("glintd %s\n", VERSION_PROGRAM);
        return 0;
    }
    if (argv[1][0] == '-')
        return verb_serve_run(argc, argv);
    for (int v = 0; v < VERBS; v++)
        if (strcmp(argv[1], verbs[v].name) == 0)
            return verbs[v].run(argc - 1, argv + 1);
    fprintf(stderr, "glintd: unknown verb '%s'; glintd --help lists them\n",
            argv[1]);
    return 2;
}
