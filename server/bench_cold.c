// bench_cold.c - one child, one connection, one frame.
#include "server/bench_cold.h"

#include <arpa/inet.h>
#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "protocol/edit.h"
#include "renderer/timer.h"

extern char **environ;

enum { WORDS_MAX = 200, LINE_MAX_BYTES = 65536, PATIENCE_S = 60 };

struct child {
    pid_t pid;
    int out; // its standard output
};

// --- the child ---------------------------------------------------------------

// One "--set NAME=VALUE" for each parameter that is not the default; words that
// end with 0 in *text, which may not grow once they are pointed at.
static void write_words(const struct bench_cold_ask *ask, struct buf *text)
{
    struct params usual;
    params_defaults(&usual);
    buf_printf(text, "glintd%cserve%c--listen%c127.0.0.1:0%c", 0, 0, 0, 0);
    buf_printf(text, "--hair%c%s%c--env%c%s%c", 0, ask->hair, 0, 0, ask->env,
               0);
    for (int i = 0; i < params_row_count; i++) {
        const struct params_row *row = &params_rows[i];
        struct buf a = {0}, b = {0};
        edit_print(&a, ask->params, row);
        edit_print(&b, &usual, row);
        if (a.size != b.size || memcmp(a.data, b.data, a.size) != 0)
            buf_printf(text, "--set%c%s.%s=%.*s%c", 0, row->group_name,
                       row->name, (int)a.size, (const char *)a.data, 0);
        buf_finish(&a);
        buf_finish(&b);
    }
}

static bool start(const struct bench_cold_ask *ask, struct child *c,
                  struct error *err)
{
    struct buf text = {0};
    char *word[WORDS_MAX + 1] = {NULL};
    int ends[2], n = 0;
    if (pipe(ends) != 0)
        return error_set(err, "state", "bench", "pipe: %s", strerror(errno));
    write_words(ask, &text);
    for (size_t at = 0; at < text.size && n < WORDS_MAX;
         at += strlen((char *)text.data + at) + 1)
        word[n++] = (char *)text.data + at;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addclose(&actions, ends[1]);
    const int failed =
        posix_spawn(&c->pid, "/proc/self/exe", &actions, NULL, word, environ);
    posix_spawn_file_actions_destroy(&actions);
    buf_finish(&text);
    close(ends[1]);
    c->out = ends[0];
    if (!failed)
        return true;
    close(ends[0]);
    return error_set(err, "state", "bench", "glintd serve: %s",
                     strerror(failed));
}

static void end(struct child *c)
{
    int status;
    kill(c->pid, SIGTERM);
    close(c->out);
    while (waitpid(c->pid, &status, 0) < 0 && errno == EINTR) {
    }
}

// --- what it says ------------------------------------------------------------

// Up to and without '\n', ends with 0; a byte at a time, for what follows is
// not a line.
static bool read_line(int fd, char *out, size_t room)
{
    for (size_t n = 0; n < room; n++) {
        if (read(fd, out + n, 1) != 1)
            return false;
        if (out[n] == '\n') {
            out[n] = 0;
            return true;
        }
    }
    return false;
}

static bool read_bytes(int fd, size_t n)
{
    char some[LINE_MAX_BYTES];
    while (n > 0) {
        const ssize_t got = read(fd, some, n < sizeof some ? n : sizeof some);
        if (got <= 0)
            return false;
        n -= (size_t)got;
    }
    return true;
}

static int connect_to(int port)
{
    const struct timeval patience = {.tv_sec = PATIENCE_S};
    struct sockaddr_in to = {.sin_family = AF_INET,
                             .sin_port = htons((uint16_t)port)};
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return -1;
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (connect(fd, (const struct sockaddr *)&to, sizeof to) == 0)
        return fd;
    close(fd);
    return -1;
}

// A frame's header is the first line that has "frame": an object.
static bool first_frame(int fd)
{
    static const char ask[] = "stream on window=2\n";
    char *line = bytes_alloc(LINE_MAX_BYTES);
    bool ok = write(fd, ask, sizeof ask - 1) == (ssize_t)sizeof ask - 1;
    const char *header = NULL, *bytes = NULL;
    while (ok && !header) {
        ok = read_line(fd, line, LINE_MAX_BYTES);
        header = ok ? strstr(line, "\"frame\":{") : NULL;
    }
    bytes = header ? strstr(header, "\"bytes\":") : NULL;
    ok = bytes && read_bytes(fd, (size_t)strtoul(bytes + 8, NULL, 10));
    free(line);
    return ok;
}

bool bench_cold_start(const struct bench_cold_ask *ask, double *ms,
                      struct error *err)
{
    struct child c;
    char line[256];
    const double began = timer_now();
    if (!start(ask, &c, err))
        return false;
    const char *colon = NULL;
    if (read_line(c.out, line, sizeof line))
        colon = strrchr(line, ':');
    const int fd = colon ? connect_to(atoi(colon + 1)) : -1;
    const bool ok = fd >= 0 && first_frame(fd);
    *ms = 1e3 * (timer_now() - began);
    if (fd >= 0)
        close(fd);
    end(&c);
    return ok || error_set(err, "state", "bench",
                           "glintd serve --hair %s: no frame came", ask->hair);
}
