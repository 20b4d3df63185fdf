// grown.h - hair of any number of strands and points, for measuring growth.
#ifndef TESTS_BENCH_GROWN_H
#define TESTS_BENCH_GROWN_H

#include "renderer/groom.h"

// Strands of builtin:straight: a share of them evenly over the head, or all
// and copies of them shifted by up to a quarter of a centimetre; each made anew
// of `points` points, evenly along its own (linear in between).  points >= 2.
struct groom *grown_groom(uint32_t strands, uint32_t points, struct error *err);

#endif
