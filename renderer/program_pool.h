// program_pool.h - the programs of one GL context: what was compiled once is
// kept when its owner lets go of it, and found again by its sources and
// definitions.  An owner has a program for itself: uniforms stay his.
// Thread: the context's.
#ifndef RENDERER_PROGRAM_POOL_H
#define RENDERER_PROGRAM_POOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"
#include "protocol/error.h"

// So many that nobody uses are kept; the oldest give way.
enum { PROGRAM_POOL_IDLE = 160, PROGRAM_POOL_KEY = 320 };

struct program_pool;

struct program_pool *program_pool_create(void);
// The context is current, and nobody uses its programs any more.
void program_pool_destroy(struct program_pool *pool); // NULL is allowed
// From now on program.h's functions on this thread are about these; NULL: about
// none, and each program is compiled anew.
void program_pool_use(struct program_pool *pool);

// For program.c.  A key is "SOURCE|SECOND SOURCE|DEFINES".  take: 0 where there
// is no idle one.
unsigned program_pool_take(const char *key);
void program_pool_add(const char *key, unsigned program, bool used);
bool program_pool_has(const char *key); // used or idle
// Gives back, or deletes what is none of the pool's.
void program_pool_give(unsigned program);

// samplers.comp with its textures bound, for program_use; 0 where it is not
// needed, or could not be had.
unsigned program_pool_neutral(void);

// So far compiled in this context; keys of all that are kept, one a line.
uint64_t program_pool_compiled(void);
size_t program_pool_count(void);
void program_pool_list(struct buf *out);

#endif
