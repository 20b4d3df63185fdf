// listener.c - binds, listens, accepts.
#include "server/listener.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "protocol/number.h"
#include "server/clock.h"
#include "server/conn.h"
#include "server/log.h"

enum {
    BACKLOG = 128,
    BATCH = 64,       // accepted in one turn
    POLITE = 64,      // beyond the limit so many are still told why
    PAUSE_US = 100000 // when descriptors have run out
};

struct listener {
    struct service *service;
    struct loop_source source;
    struct loop_timer pause;
    int spare; // given up to accept and close when descriptors run out
    bool local;
    char name[128];
    char *path; // of a Unix socket, to be removed
    int port;
};

union address {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
    struct sockaddr_un local;
};

static void pause_over(struct loop_timer *t)
{
    struct listener *l =
        (struct listener *)((char *)t - offsetof(struct listener, pause));
    loop_change(l->service->loop, &l->source, EPOLLIN);
}

static void no_descriptors(struct listener *l)
{
    if (l->spare >= 0)
        close(l->spare);
    int fd = accept4(l->source.fd, NULL, NULL, SOCK_CLOEXEC);
    if (fd >= 0)
        close(fd);
    l->spare = open("/dev/null", O_RDONLY | O_CLOEXEC);
    loop_change(l->service->loop, &l->source, 0);
    loop_timer_set(l->service->loop, &l->pause, clock_us() + PAUSE_US);
    log_line("no file descriptor is left for a connection");
}

static void ready(struct loop_source *source, uint32_t events)
{
    struct listener *l =
        (struct listener *)((char *)source - offsetof(struct listener, source));
    struct service *s = l->service;
    (void)events;
    for (int i = 0; i < BATCH; i++) {
        int fd = accept4(source->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd < 0 && (errno == EMFILE || errno == ENFILE)) {
            no_descriptors(l);
            return;
        }
        if (fd < 0 && errno != EINTR && errno != ECONNABORTED)
            return;
        if (fd < 0)
            continue;
        if (s->connections >= s->connections_max + POLITE)
            close(fd);
        else
            conn_open(s, fd, l->local);
    }
}

// --- addresses --------------------------------------------------------------
static bool parse(const char *text, union address *a, socklen_t *size,
                  struct error *err)
{
    const char *colon = strrchr(text, ':');
    uint64_t port;
    char host[64];
    size_t n = colon ? (size_t)(colon - text) : 0;
    if (!colon || n == 0 || n >= sizeof host ||
        !number_parse_u64(
            (struct span){(const unsigned char *)colon + 1, strlen(colon + 1)},
            65535, &port))
        return error_set(err, "syntax", "listen",
                         "--listen %s: expected HOST:PORT with a port within "
                         "[0, 65535]",
                         text);
    memcpy(host, text, n);
    host[n] = 0;
    *a = (union address){0};
    bool v6 = host[0] == '[' && host[n - 1] == ']';
    if (v6) {
        host[n - 1] = 0;
        a->v6.sin6_family = AF_INET6;
        a->v6.sin6_port = htons((uint16_t)port);
        *size = sizeof a->v6;
        if (inet_pton(AF_INET6, host + 1, &a->v6.sin6_addr) == 1)
            return true;
    } else {
        const char *v4 = strcmp(host, "localhost") == 0 ? "127.0.0.1" : host;
        a->v4.sin_family = AF_INET;
        a->v4.sin_port = htons((uint16_t)port);
        *size = sizeof a->v4;
        if (inet_pton(AF_INET, v4, &a->v4.sin_addr) == 1)
            return true;
    }
    return error_set(err, "syntax", "listen",
                     "--listen %s: not an IPv4 address, an IPv6 address in "
                     "brackets, or localhost",
                     text);
}

static bool is_loopback(const union address *a)
{
    if (a->any.sa_family == AF_INET)
        return ntohl(a->v4.sin_addr.s_addr) >> 24 == 127;
    return IN6_IS_ADDR_LOOPBACK(&a->v6.sin6_addr);
}

static void name_bound(struct listener *l)
{
    union address a;
    socklen_t size = sizeof a;
    char host[INET6_ADDRSTRLEN] = "";
    if (getsockname(l->source.fd, &a.any, &size) != 0)
        return;
    bool v6 = a.any.sa_family == AF_INET6;
    inet_ntop(a.any.sa_family,
              v6 ? (const void *)&a.v6.sin6_addr : (const void *)&a.v4.sin_addr,
              host, sizeof host);
    l->port = ntohs(v6 ? a.v6.sin6_port : a.v4.sin_port);
    snprintf(l->name, sizeof l->name, v6 ? "[%s]:%d" : "%s:%d", host, l->port);
}

// --- opening ----------------------------------------------------------------
static struct listener *create(struct service *s, int family)
{
    struct listener *l = bytes_zalloc(1, sizeof *l);
    l->service = s;
    l->spare = open("/dev/null", O_RDONLY | O_CLOEXEC);
    l->pause.fire = pause_over;
    l->source.ready = ready;
    l->source.fd =
        socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    return l;
}

static bool bind_and_listen(struct listener *l, const union address *a,
                            socklen_t size)
{
    return l->source.fd >= 0 && bind(l->source.fd, &a->any, size) == 0 &&
           listen(l->source.fd, BACKLOG) == 0 &&
           loop_watch(l->service->loop, &l->source, EPOLLIN);
}

struct listener *listener_tcp(struct service *s, struct listener_address where,
                              struct error *err)
{
    union address a;
    socklen_t size = 0;
    int one = 1;
    if (!parse(where.text, &a, &size, err))
        return NULL;
    if (!is_loopback(&a) && !where.any_address) {
        error_set(err, "denied", "listen",
                  "--listen %s: other machines can reach this address, so "
                  "--token-file is needed (nothing is encrypted: a tunnel is "
                  "better)",
                  where.text);
        return NULL;
    }
    struct listener *l = create(s, a.any.sa_family);
    if (l->source.fd >= 0)
        setsockopt(l->source.fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    if (bind_and_listen(l, &a, size)) {
        name_bound(l);
        return l;
    }
    error_set(err, "system", "listen", "--listen %s: %s", where.text,
              errno == EADDRINUSE ? "the port is in use" : strerror(errno));
    listener_destroy(l);
    return NULL;
}

// Removes the socket file of a daemon that is gone.
static void remove_stale(const union address *a, socklen_t size)
{
    struct stat st;
    if (lstat(a->local.sun_path, &st) != 0 || !S_ISSOCK(st.st_mode))
        return;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return;
    if (connect(fd, &a->any, size) != 0 && errno == ECONNREFUSED)
        unlink(a->local.sun_path);
    close(fd);
}

struct listener *listener_unix(struct service *s, const char *path,
                               struct error *err)
{
    union address a = {.local = {.sun_family = AF_UNIX}};
    if (strlen(path) >= sizeof a.local.sun_path) {
        error_set(err, "limit", path, "--unix %s: longer than %zu bytes", path,
                  sizeof a.local.sun_path - 1);
        return NULL;
    }
    snprintf(a.local.sun_path, sizeof a.local.sun_path, "%s", path);
    remove_stale(&a, sizeof a.local);
    struct listener *l = create(s, AF_UNIX);
    l->local = true;
    mode_t before = umask(0077);
    bool ok = bind_and_listen(l, &a, sizeof a.local);
    int why = errno;
    umask(before);
    if (ok) {
        size_t n = strlen(path) + 1;
        l->path = memcpy(bytes_alloc(n), path, n);
        snprintf(l->name, sizeof l->name, "%s", path);
        return l;
    }
    error_set(err, "system", "unix", "--unix %s: %s", path,
              why == EADDRINUSE ? "the name is in use" : strerror(why));
    listener_destroy(l);
    return NULL;
}

const char *listener_name(const struct listener *l)
{
    return l->name;
}

int listener_port(const struct listener *l)
{
    return l->port;
}

void listener_destroy(struct listener *l)
{
    if (!l)
        return;
    loop_unwatch(l->service->loop, &l->source);
    loop_timer_clear(l->service->loop, &l->pause);
    if (l->source.fd >= 0)
        close(l->source.fd);
    if (l->spare >= 0)
        close(l->spare);
    if (l->path)
        unlink(l->path);
    free(l->path);
    free(l);
}
