// frames.h - whole pictures at the limits: hair, skies and parameters that
// nobody would choose.
#ifndef TESTS_EXTREMES_FRAMES_H
#define TESTS_EXTREMES_FRAMES_H

enum { FRAMES_HAIRS = 14, FRAMES_SKIES = 9 };

struct frames_row {
    const char *what;
    long frames, bad; // not finite, below 0, coverage above 1, above the bound
    long lit;         // with light in them
    double top;       // brightest value over the sum of the lights' L_j
    double slowest;   // seconds, of any load on the machine
};

struct frames_all {
    struct frames_row hair[FRAMES_HAIRS], sky[FRAMES_SKIES];
    long frames, fits, fresh, differ; // of `fresh` pictures made anew
};

// `count` frames, hair by hair and sky by sky, one renderer for all; every
// `every`-th is made once more by a fresh renderer and compared bit for bit.
struct frames_all frames_run(int count, int every);

#endif
