// scale.h - what bench_scale.c measured, and how it is written down.
#ifndef TESTS_BENCH_SCALE_H
#define TESTS_BENCH_SCALE_H

#include <stdint.h>

#include "protocol/bytes.h"

enum { SCALE_ROWS = 16, SCALE_EDITS = 3 };
extern const char
    *const scale_edits[SCALE_EDITS]; // fibre, light colour, camera

struct scale_row {
    double x;
    char label[48];                           // "1920 x 1080"; "" : the number
    double ms[SCALE_EDITS], cpu[SCALE_EDITS]; // medians; of all processors
    uint32_t points, strand_points;           // visible; of the hair
    int lights;                               // in use
    int light_tables, missing;                // that these share; have none
    const char *path;
    uint64_t strands, shadow, cache, targets, tables; // bytes
    char refused[240]; // why there is nothing; ""
};

struct scale_sweep {
    const char *name, *id, *x; // "strands", "strands", "strands of 25 points"
    const char *about;
    struct scale_row row[SCALE_ROWS];
    int rows;
};

uint64_t scale_memory(const struct scale_row *r); // bytes, all
void scale_json(const struct scale_sweep *s, const struct scale_row *r,
                struct buf *out);
void scale_section(const struct scale_sweep *s, const char *plot,
                   struct buf *out);
// One line: exponents of times and memory.
void scale_summary(const struct scale_sweep *s, struct buf *out);
void scale_plot(const struct scale_sweep *s, const char *device,
                struct buf *out);

#endif
