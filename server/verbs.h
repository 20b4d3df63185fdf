// verbs.h - what `glintd VERB` can do.  One file verb_NAME.c each.
//
// argv[0] is the verb (or the program's name where the verb was left out),
// options follow.  The result is the exit status: 0 done, 1 failed with one
// line on stderr, 2 wrong usage.
// Thread: main.
#ifndef SERVER_VERBS_H
#define SERVER_VERBS_H

int verb_serve_run(int argc, char **argv);  // the daemon
int verb_render_run(int argc, char **argv); // one picture into a file
int verb_probe_run(int argc, char **argv);  // single integrals
int verb_bench_run(int argc, char **argv);  // error against run time
int verb_fit_run(int argc, char **argv);    // a sky's lights
int verb_info_run(int argc, char **argv);   // what is here

#endif
