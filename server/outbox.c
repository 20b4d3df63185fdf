// outbox.c - a list of things to write, given to sendmsg a few at a time.
#include "server/outbox.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>

enum {
    CHUNK = 2048,      // own bytes are gathered into items of at least this
    PIECES = 16,       // of one sendmsg
    TURN = 4 * 1 << 20 // bytes of one call, so that others get their turn
};

struct outbox_item {
    struct outbox_item *next;
    struct blob *blob; // or NULL: own bytes
    struct buf own;
};

static struct outbox_item *add(struct outbox *o)
{
    struct outbox_item *i = bytes_zalloc(1, sizeof *i);
    if (o->last)
        o->last->next = i;
    else
        o->first = i;
    o->last = i;
    return i;
}

static void drop_first(struct outbox *o)
{
    struct outbox_item *i = o->first;
    o->first = i->next;
    if (!o->first)
        o->last = NULL;
    o->offset = 0;
    if (i->blob)
        o->blobs--;
    blob_unref(i->blob);
    buf_finish(&i->own);
    free(i);
}

void outbox_finish(struct outbox *o)
{
    while (o->first)
        drop_first(o);
    o->replies = 0;
}

bool outbox_empty(const struct outbox *o)
{
    return !o->first;
}

void outbox_bytes(struct outbox *o, const void *data, size_t size)
{
    if (size == 0)
        return;
    struct outbox_item *i = o->last;
    if (!i || i->blob || i->own.size >= CHUNK)
        i = add(o);
    buf_append(&i->own, data, size);
    o->replies += size;
}

void outbox_blob(struct outbox *o, struct blob *b)
{
    if (b->size == 0)
        return;
    add(o)->blob = blob_ref(b);
    o->blobs++;
}

static struct span bytes_of(const struct outbox_item *i)
{
    return i->blob ? (struct span){i->blob->data, i->blob->size}
                   : (struct span){i->own.data, i->own.size};
}

static void advance(struct outbox *o, size_t n)
{
    while (n > 0) {
        size_t left = bytes_of(o->first).size - o->offset;
        size_t take = n < left ? n : left;
        if (!o->first->blob)
            o->replies -= take;
        o->offset += take;
        n -= take;
        if (take == left)
            drop_first(o);
    }
}

enum outbox_result outbox_write(struct outbox *o, int fd, size_t *wrote)
{
    *wrote = 0;
    while (o->first && *wrote < TURN) {
        struct iovec v[PIECES];
        int n = 0;
        size_t offset = o->offset;
        for (struct outbox_item *i = o->first; i && n < PIECES; i = i->next) {
            struct span s = bytes_of(i);
            v[n++] = (struct iovec){(void *)(s.data + offset), s.size - offset};
            offset = 0;
        }
        struct msghdr m = {.msg_iov = v, .msg_iovlen = (size_t)n};
        ssize_t put = sendmsg(fd, &m, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (put < 0 && errno == EINTR)
            continue;
        if (put < 0 && (errno == EAGAIN || errno == ENOBUFS))
            return OUTBOX_BLOCKED;
        if (put < 0)
            return OUTBOX_BROKEN;
        *wrote += (size_t)put;
        advance(o, (size_t)put);
    }
    return o->first ? OUTBOX_BLOCKED : OUTBOX_DONE;
}
