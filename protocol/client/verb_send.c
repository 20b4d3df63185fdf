// verb_send.c - `glint send`: raw request lines from the standard input, the
// daemon's lines to the standard output.  The protocol by hand.
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "protocol/client/reply.h"
#include "protocol/client/verbs.h"

#define PENDING_MAX (256u << 10) // bytes read ahead of what was sent

struct sender {
    const struct verbs_options *o;
    struct wire w;
    struct buf out; // not yet sent
    bool input_over, line_open;
    uint64_t asked, answered, refused;
};

// Counts the requests in what is about to be sent: every line is one.
static void count(struct sender *s, struct span bytes)
{
    for (size_t i = 0; i < bytes.size; i++) {
        s->asked += bytes.data[i] == '\n';
        s->line_open = bytes.data[i] != '\n';
    }
}

static bool read_input(struct sender *s, struct error *err)
{
    unsigned char chunk[16384];
    ssize_t n = read(STDIN_FILENO, chunk, sizeof chunk);
    if (n < 0 && errno != EINTR && errno != EAGAIN)
        return error_set(err, "file", "", "reading the standard input: %s",
                         strerror(errno));
    if (n == 0) {
        s->input_over = true;
        if (s->line_open) { // the last line had no end
            count(s, (struct span){(const unsigned char *)"\n", 1});
            buf_byte(&s->out, '\n');
        }
    }
    if (n > 0) {
        count(s, (struct span){chunk, (size_t)n});
        buf_append(&s->out, chunk, (size_t)n);
    }
    return true;
}

// Everything that has come whole.
static bool take(struct sender *s, struct error *err)
{
    struct span line;
    struct reply r;
    while (wire_ready(&s->w, &line)) {
        if (!reply_read(&r, line, err))
            return false;
        printf("%.*s\n", (int)line.size, (const char *)line.data);
        fflush(stdout);
        s->answered += r.answers;
        s->refused += r.answers && !r.ok;
        struct reply_frame frame = r.frame;
        if (r.has_frame && !verbs_keep(s->o, &s->w, &frame, err))
            return false;
    }
    return true;
}

static bool give(struct sender *s, struct error *err)
{
    ssize_t n = send(s->w.fd, s->out.data, s->out.size, MSG_NOSIGNAL);
    if (n > 0)
        buf_drop(&s->out, (size_t)n);
    return n >= 0 || errno == EAGAIN || errno == EINTR ||
           error_set(err, "wire", "", "sending to the daemon: %s",
                     strerror(errno));
}

// One round: wait for whatever can go on.
static bool step(struct sender *s, struct error *err)
{
    bool hungry = !s->input_over && s->out.size < PENDING_MAX;
    bool busy = s->out.size > 0;
    struct pollfd p[2] = {
        {.fd = s->w.fd, .events = (short)(POLLIN | (busy ? POLLOUT : 0))},
        {.fd = hungry ? STDIN_FILENO : -1, .events = POLLIN}};
    int n = poll(p, 2, hungry ? -1 : s->w.timeout_ms);
    if (n < 0)
        return errno == EINTR ||
               error_set(err, "wire", "", "poll: %s", strerror(errno));
    if (n == 0)
        return error_set(err, "timeout", "",
                         "the daemon was silent for %g s (see --timeout)",
                         s->w.timeout_ms / 1e3);
    if (p[1].revents && !read_input(s, err))
        return false;
    if ((p[0].revents & POLLOUT) && !give(s, err))
        return false;
    if (p[0].revents & ~POLLOUT)
        return wire_fill(&s->w, err) && take(s, err);
    return true;
}

bool verb_send_run(const struct verbs_options *o, struct error *err)
{
    struct sender s = {.o = o};
    if (o->arg_count > 0)
        return error_set(err, "usage", "",
                         "send reads its lines from the standard input, not "
                         "\"%.60s\"",
                         o->args[0]);
    if (!verbs_make_folder(o, err))
        return false;
    bool ok = verbs_connect(&s.w, o, 3600, err) && take(&s, err);
    while (ok && !(s.input_over && s.out.size == 0 && s.answered >= s.asked))
        ok = step(&s, err);
    if (ok && s.refused > 0)
        ok = error_set(err, "refused", "", "%llu of %llu requests were refused",
                       (unsigned long long)s.refused,
                       (unsigned long long)s.asked);
    wire_close(&s.w);
    buf_finish(&s.out);
    return ok;
}
