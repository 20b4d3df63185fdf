// wire.c - the client's socket.  What the lines say is left to reply.c.
#include "protocol/client/wire.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

// --- connecting -------------------------------------------------------------

static bool unreachable(const char *where, const char *why, struct error *err)
{
    return error_set(err, "connect", where,
                     "no daemon at %s (%s); start one with `glintd serve`, or "
                     "name another with --connect HOST:PORT or --unix PATH",
                     where, why);
}

// Non-blocking for good: every wait is a poll with a limit.
static bool connect_to(int fd, const struct sockaddr *to, socklen_t size)
{
    struct pollfd p = {.fd = fd, .events = POLLOUT};
    int failure = 0;
    socklen_t length = sizeof failure;
    if (connect(fd, to, size) == 0)
        return true;
    if (errno != EINPROGRESS)
        return false;
    int n;
    while ((n = poll(&p, 1, WIRE_CONNECT_MS)) < 0 && errno == EINTR) {
    }
    if (n == 0)
        failure = ETIMEDOUT;
    else if (getsockopt(fd, SOL_SOCKET, SO_ERROR, &failure, &length) != 0)
        return false;
    errno = failure;
    return failure == 0;
}

static bool open_unix(struct wire *w, const char *path, struct error *err)
{
    struct sockaddr_un to = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof to.sun_path)
        return error_set(err, "usage", "--unix",
                         "--unix: a path of %zu bytes is longer than the %zu "
                         "that a socket may have",
                         strlen(path), sizeof to.sun_path - 1);
    memcpy(to.sun_path, path, strlen(path) + 1);
    w->fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (w->fd < 0 ||
        !connect_to(w->fd, (const struct sockaddr *)&to, sizeof to))
        return unreachable(path, strerror(errno), err);
    return true;
}

// "HOST:PORT" and "[HOST]:PORT" into two texts.
static bool split(const char *address, char host[256], char port[16])
{
    const char *colon = strrchr(address, ':');
    size_t size = colon ? (size_t)(colon - address) : 0;
    if (size > 1 && address[0] == '[' && address[size - 1] == ']') {
        address++;
        size -= 2;
    } else if (memchr(address, ':', size)) {
        return false;
    }
    if (size == 0 || size > 255 || strlen(colon + 1) > 5 ||
        strspn(colon + 1, "0123456789") != strlen(colon + 1) || !colon[1])
        return false;
    memcpy(host, address, size);
    host[size] = 0;
    memcpy(port, colon + 1, strlen(colon + 1) + 1);
    return true;
}

static bool open_tcp(struct wire *w, const char *address, struct error *err)
{
    char host[256], port[16];
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM}, *list = NULL;
    if (!split(address, host, port))
        return error_set(err, "usage", "--connect",
                         "--connect: \"%s\" is not of the form HOST:PORT",
                         address);
    int status = getaddrinfo(host, port, &hints, &list);
    if (status != 0)
        return unreachable(address, gai_strerror(status), err);
    for (struct addrinfo *a = list; a; a = a->ai_next) {
        int on = 1;
        w->fd =
            socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                   a->ai_protocol);
        if (w->fd >= 0 && connect_to(w->fd, a->ai_addr, a->ai_addrlen)) {
            setsockopt(w->fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            freeaddrinfo(list);
            return true;
        }
        int why = errno;
        if (w->fd >= 0)
            close(w->fd);
        w->fd = -1;
        errno = why;
    }
    freeaddrinfo(list);
    return unreachable(address, strerror(errno), err);
}

bool wire_open(struct wire *w, const char *address, const char *path,
               struct error *err)
{
    *w = (struct wire){.fd = -1, .timeout_ms = -1};
    return path ? open_unix(w, path, err) : open_tcp(w, address, err);
}

void wire_close(struct wire *w)
{
    if (w->fd > 0)
        close(w->fd);
    buf_finish(&w->in);
    *w = (struct wire){.fd = -1};
}

// --- bytes ------------------------------------------------------------------

static bool await(struct wire *w, short events, struct error *err)
{
    struct pollfd p = {.fd = w->fd, .events = events};
    int n;
    while ((n = poll(&p, 1, w->timeout_ms)) < 0 && errno == EINTR) {
    }
    if (n == 0)
        return error_set(err, "timeout", "",
                         "the daemon was silent for %g s (see --timeout)",
                         w->timeout_ms / 1e3);
    return n > 0 || error_set(err, "wire", "", "poll: %s", strerror(errno));
}

bool wire_send(struct wire *w, struct span bytes, struct error *err)
{
    while (bytes.size > 0) {
        ssize_t n = send(w->fd, bytes.data, bytes.size, MSG_NOSIGNAL);
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
            if (!await(w, POLLOUT, err))
                return false;
            continue;
        }
        if (n < 0)
            return error_set(err, "wire", "", "sending to the daemon: %s",
                             strerror(errno));
        bytes.data += n;
        bytes.size -= (size_t)n;
    }
    return true;
}

bool wire_fill(struct wire *w, struct error *err)
{
    buf_drop(&w->in, w->at);
    w->at = 0;
    for (;;) {
        buf_reserve(&w->in, 65536);
        ssize_t n = recv(w->fd, w->in.data + w->in.size, 65536, 0);
        if (n > 0) {
            w->in.size += (size_t)n;
            return true;
        }
        if (n == 0)
            return error_set(err, "wire", "",
                             "the daemon closed the connection");
        if (errno != EAGAIN && errno != EINTR)
            return error_set(err, "wire", "", "receiving from the daemon: %s",
                             strerror(errno));
        if (!await(w, POLLIN, err))
            return false;
    }
}

bool wire_ready(struct wire *w, struct span *line)
{
    size_t from = w->at + w->scanned;
    const unsigned char *end =
        from < w->in.size ? memchr(w->in.data + from, '\n', w->in.size - from)
                          : NULL;
    if (!end) {
        w->scanned = w->in.size - w->at;
        return false;
    }
    *line =
        (struct span){w->in.data + w->at, (size_t)(end - w->in.data) - w->at};
    w->at += line->size + 1;
    w->scanned = 0;
    return true;
}

bool wire_line(struct wire *w, struct span *line, struct error *err)
{
    while (!wire_ready(w, line)) {
        if (w->in.size - w->at > WIRE_LINE_MAX)
            return error_set(err, "wire", "",
                             "a line of the daemon is longer than %u bytes",
                             WIRE_LINE_MAX);
        if (!wire_fill(w, err))
            return false;
    }
    return true;
}

bool wire_bytes(struct wire *w, uint64_t size, struct save *to,
                struct error *err)
{
    while (size > 0) {
        struct span part = {w->in.data + w->at, w->in.size - w->at};
        if (part.size > size)
            part.size = (size_t)size;
        if (part.size == 0 && !wire_fill(w, err))
            return false;
        if (part.size > 0 && to && !save_write(to, part, err))
            return false;
        w->at += part.size;
        size -= part.size;
    }
    return true;
}
