// bytes.c - memory for bytes.  No file, socket or clock is touched here.
#include "protocol/bytes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *must(void *p, size_t size)
{
    if (!p && size > 0) {
        fprintf(stderr, "glint: out of memory (%zu bytes)\n", size);
        abort();
    }
    return p;
}

void *bytes_alloc(size_t size)
{
    return must(malloc(size), size);
}

void *bytes_zalloc(size_t count, size_t size)
{
    return must(calloc(count, size), count * size);
}

void *bytes_realloc(void *p, size_t size)
{
    return must(realloc(p, size), size);
}

void buf_finish(struct buf *b)
{
    free(b->data);
    *b = (struct buf){0};
}

void buf_clear(struct buf *b)
{
    b->size = 0;
}

void buf_reserve(struct buf *b, size_t more)
{
    if (more <= b->cap - b->size)
        return;
    size_t cap = b->cap ? b->cap : 256;
    while (cap - b->size < more)
        cap += cap / 2;
    b->data = bytes_realloc(b->data, cap);
    b->cap = cap;
}

unsigned char *buf_grow(struct buf *b, size_t more)
{
    buf_reserve(b, more);
    unsigned char *at = b->data + b->size;
    b->size += more;
    return at;
}

void buf_append(struct buf *b, const void *data, size_t size)
{
    if (size > 0)
        memcpy(buf_grow(b, size), data, size);
}

void buf_byte(struct buf *b, unsigned char c)
{
    *buf_grow(b, 1) = c;
}

void buf_text(struct buf *b, const char *text)
{
    buf_append(b, text, strlen(text));
}

void buf_vprintf(struct buf *b, const char *fmt, va_list ap)
{
    va_list again;
    va_copy(again, ap);
    int n = vsnprintf(NULL, 0, fmt, ap);
    if (n > 0) {
        buf_reserve(b, (size_t)n + 1);
        vsnprintf((char *)b->data + b->size, (size_t)n + 1, fmt, again);
        b->size += (size_t)n;
    }
    va_end(again);
}

void buf_printf(struct buf *b, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    buf_vprintf(b, fmt, ap);
    va_end(ap);
}

void buf_drop(struct buf *b, size_t n)
{
    if (n == 0) // an empty buffer has no data to point into
        return;
    memmove(b->data, b->data + n, b->size - n);
    b->size -= n;
}

struct blob *blob_from(const void *data, size_t size)
{
    struct blob *b = bytes_alloc(sizeof *b + size);
    atomic_init(&b->refs, 1);
    b->size = size;
    if (size > 0)
        memcpy(b->data, data, size);
    return b;
}

struct blob *blob_ref(struct blob *b)
{
    atomic_fetch_add_explicit(&b->refs, 1, memory_order_relaxed);
    return b;
}

void blob_unref(struct blob *b)
{
    if (b && atomic_fetch_sub_explicit(&b->refs, 1, memory_order_acq_rel) == 1)
        free(b);
}
