// bytes.h - the three shapes in which bytes travel: a borrowed span, a growing
// buffer with one owner, an immutable blob shared by reference count.
// Running out of memory aborts: sizes that a client or a file derives are
// checked against a limit before anything here is called.
// Thread: span and buf belong to one thread at a time; blob_ref and blob_unref
// may be called from any.
#ifndef PROTOCOL_BYTES_H
#define PROTOCOL_BYTES_H

#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>

struct span {
    const unsigned char *data;
    size_t size;
};

struct buf { // zero-initialised is empty
    unsigned char *data;
    size_t size, cap;
};

void buf_finish(struct buf *b); // frees; leaves an empty buf
void buf_clear(struct buf *b);  // empties; keeps the memory
void buf_reserve(struct buf *b, size_t more);
unsigned char *buf_grow(struct buf *b, size_t more); // appended, not yet set
void buf_append(struct buf *b, const void *data, size_t size);
void buf_byte(struct buf *b, unsigned char c);
void buf_text(struct buf *b, const char *text);
void buf_printf(struct buf *b, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
void buf_vprintf(struct buf *b, const char *fmt, va_list ap);
void buf_drop(struct buf *b, size_t n); // removes the first n bytes

struct blob {
    atomic_int refs;
    size_t size;
    unsigned char data[];
};

struct blob *blob_from(const void *data, size_t size); // one reference
struct blob *blob_ref(struct blob *b);
void blob_unref(struct blob *b); // NULL is allowed

// malloc, calloc and realloc that abort instead of returning NULL.
void *bytes_alloc(size_t size);
void *bytes_zalloc(size_t count, size_t size);
void *bytes_realloc(void *p, size_t size);

#endif
