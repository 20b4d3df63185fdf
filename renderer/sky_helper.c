// sky_helper.c - both ends of the decoding helper: the parent that starts it,
// waits and mistrusts what comes back, and the child that limits itself and
// decodes.  What a file's bytes mean is left to sky_exr.c and sky_rgbe.c.
#include "renderer/sky_helper.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "renderer/sky.h"

const char *const sky_helper_name = "glint-sky-helper";

enum { FD_IN = 3, FD_OUT = 4, FD_REPORT = 5 }; // in the helper

#define MEMORY \
    ((rlim_t)1536 << 20) // beyond what the empty program maps:
                         // pixels of the largest map, twice, and
                         // blocks in work

struct report { // through the pipe, whole
    uint32_t magic;
    int32_t ok, width, height;
    struct error error;
};
static const uint32_t report_magic = 0x474c5359;

// --- the helper ------------------------------------------------------------

#define LIMIT(what, value) \
    setrlimit(what, &(struct rlimit){.rlim_cur = (value), .rlim_max = (value)})

// Bytes of address space in use, from the kernel's count of pages.
static rlim_t mapped(void)
{
    FILE *f = fopen("/proc/self/statm", "re");
    unsigned long pages = 0;
    if (f && fscanf(f, "%lu", &pages) != 1)
        pages = 0;
    if (f)
        fclose(f);
    return (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE);
}

static void limit_self(void)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    prctl(PR_SET_DUMPABLE, 0);
    close_range(FD_REPORT + 1, ~0u, 0);
    // Relative to what is mapped already, so it holds with the shadow memory
    // of a sanitizer as well, whose reservations are made by now.
    rlim_t used = mapped();
    if (used > 0)
        LIMIT(RLIMIT_AS, used + MEMORY);
    LIMIT(RLIMIT_CPU, SKY_HELPER_SECONDS);
    LIMIT(RLIMIT_CORE, 0);
    LIMIT(RLIMIT_FSIZE, (rlim_t)SKY_PIXELS_MAX * 12);
    LIMIT(RLIMIT_NOFILE, 16);
}

static bool write_all(int fd, const void *data, size_t size)
{
    const char *at = data;
    while (size > 0) {
        ssize_t n = write(fd, at, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        at += n;
        size -= (size_t)n;
    }
    return true;
}

static bool decode(struct sky_pixels *p, struct error *err)
{
    struct stat st;
    if (fstat(FD_IN, &st) != 0 || st.st_size < 4)
        return error_set(err, "file", "", "the file is empty");
    size_t size = (size_t)st.st_size;
    void *map = mmap(NULL, size, PROT_READ, MAP_PRIVATE, FD_IN, 0);
    if (map == MAP_FAILED)
        return error_set(err, "file", "", "cannot be mapped: %s",
                         strerror(errno));
    struct span file = {map, size};
    bool ok = memcmp(map, "#?", 2) == 0
                  ? sky_rgbe_read(file, p, err)
                  : sky_exr_read(file, "/proc/self/fd/3", p, err);
    munmap(map, size);
    return ok;
}

void sky_helper_main(int argc, char **argv)
{
    if (argc != 1 || !argv[0] || strcmp(argv[0], sky_helper_name) != 0)
        return;
    limit_self();
    struct sky_pixels p = {0};
    struct report r = {.magic = report_magic};
    r.ok = decode(&p, &r.error);
    if (r.ok) {
        r.width = p.width;
        r.height = p.height;
        size_t size = (size_t)p.width * (size_t)p.height * 12;
        if (!write_all(FD_OUT, p.rgb, size))
            r.ok = error_set(&r.error, "file", "", "cannot hand over: %s",
                             strerror(errno));
    }
    bool sent = write_all(FD_REPORT, &r, sizeof r);
    _exit(sent ? 0 : 1); // no exit handlers: the libraries' may hang
}

// --- the parent ------------------------------------------------------------

struct child {
    pid_t pid;
    int out, report; // the pixels' file, the pipe's read end
    struct timespec deadline;
};

static int until(const struct timespec *deadline) // milliseconds
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    int64_t ms = (int64_t)(deadline->tv_sec - now.tv_sec) * 1000 +
                 (deadline->tv_nsec - now.tv_nsec) / 1000000;
    return ms > 0 ? (int)ms : 0;
}

// Numbers 3 to 5 in the helper, whatever they are here; dup2 onto itself would
// lose a descriptor to another's number, so all are moved up first.
static int spawn(pid_t *pid, const int fds[3])
{
    int high[3] = {-1, -1, -1}, rv = 0;
    for (int i = 0; i < 3; i++)
        if ((high[i] = fcntl(fds[i], F_DUPFD_CLOEXEC, 10)) < 0)
            rv = errno;
    posix_spawn_file_actions_t fa;
    posix_spawnattr_t attr;
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawn_file_actions_init(&fa);
    posix_spawnattr_init(&attr);
    posix_spawnattr_setflags(&attr,
                             POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
    posix_spawnattr_setsigdefault(&attr, &all);
    posix_spawnattr_setsigmask(&attr, &none);
    // The libraries print to stderr what the report says better; a sanitizer's
    // words must be seen.
    int quiet = 3;
#ifdef GLINT_SANITIZED
    quiet = 2;
#endif
    for (int i = 0; i < quiet; i++)
        posix_spawn_file_actions_addopen(&fa, i, "/dev/null", O_RDWR, 0);
    for (int i = 0; i < 3; i++)
        posix_spawn_file_actions_adddup2(&fa, high[i], FD_IN + i);
    char *argv[] = {(char *)sky_helper_name, NULL};
    if (rv == 0)
        rv = posix_spawn(pid, "/proc/self/exe", &fa, &attr, argv, environ);
    posix_spawnattr_destroy(&attr);
    posix_spawn_file_actions_destroy(&fa);
    for (int i = 0; i < 3; i++)
        if (high[i] >= 0)
            close(high[i]);
    return rv;
}

static bool child_start(struct child *c, int in, struct error *err)
{
    int ends[2] = {-1, -1}, rv = 0;
    c->out = memfd_create("glint-sky", MFD_CLOEXEC);
    if (c->out < 0 || pipe2(ends, O_CLOEXEC) != 0)
        rv = errno;
    c->report = ends[0];
    clock_gettime(CLOCK_MONOTONIC, &c->deadline);
    c->deadline.tv_sec += SKY_HELPER_SECONDS;
    if (rv == 0)
        rv = spawn(&c->pid, (const int[3]){in, c->out, ends[1]});
    if (ends[1] >= 0)
        close(ends[1]); // so that the helper's death ends the pipe
    if (rv != 0) {
        c->pid = 0;
        return error_set(err, "file", "", "cannot start the decoder: %s",
                         strerror(rv));
    }
    return true;
}

// Reads up to size bytes before the deadline; stops at the end of the pipe.
static size_t read_report(const struct child *c, void *to, size_t size,
                          bool *late)
{
    size_t got = 0;
    *late = false;
    while (got < size) {
        struct pollfd p = {.fd = c->report, .events = POLLIN};
        int n = poll(&p, 1, until(&c->deadline));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            *late = true;
            break;
        }
        ssize_t r = read(c->report, (char *)to + got, size - got);
        if (r < 0 && errno == EINTR)
            continue;
        if (r <= 0)
            break;
        got += (size_t)r;
    }
    return got;
}

// Waits for the end until the deadline, then enforces it.
static int reap(const struct child *c, bool *late)
{
    int status = 0;
    const struct timespec nap = {0, 2000000};
    while (waitpid(c->pid, &status, WNOHANG) == 0) {
        if (*late || until(&c->deadline) == 0) {
            *late = true;
            kill(c->pid, SIGKILL);
            while (waitpid(c->pid, &status, 0) < 0 && errno == EINTR)
                continue;
            break;
        }
        nanosleep(&nap, NULL);
    }
    return status;
}

static bool judge(const struct report *r, size_t got, int status, bool late,
                  struct error *err)
{
    int sig = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (late || sig == SIGXCPU)
        return error_set(err, "limit", "",
                         "decoding took longer than %d s and was stopped",
                         SKY_HELPER_SECONDS);
    if (sig == SIGABRT)
        return error_set(err, "limit", "",
                         "the decoder gave up (out of the %d MB it may use, or "
                         "the file is damaged)",
                         (int)(MEMORY >> 20));
    if (sig != 0)
        return error_set(err, "file", "",
                         "the decoder crashed on it (signal %d)", sig);
    if (got != sizeof *r || r->magic != report_magic || status != 0)
        return error_set(err, "file", "",
                         "the decoder failed on it (status %d)",
                         WEXITSTATUS(status));
    if (r->ok)
        return true;
    return error_set(err, r->error.code, r->error.name, "%s", r->error.text);
}

static bool fetch(int fd, const struct report *r, struct sky_pixels *out,
                  struct error *err)
{
    if (!sky_pixels_create(out, r->width, r->height, err))
        return false;
    size_t size = (size_t)out->width * (size_t)out->height * 12, got = 0;
    struct stat st;
    bool ok = fstat(fd, &st) == 0 && st.st_size == (off_t)size;
    while (ok && got < size) {
        ssize_t n = pread(fd, (char *)out->rgb + got, size - got, (off_t)got);
        if (n < 0 && errno == EINTR)
            continue;
        ok = n > 0;
        got += ok ? (size_t)n : 0;
    }
    if (ok)
        return true;
    sky_pixels_finish(out);
    return error_set(err, "file", "",
                     "the decoder returned %lld bytes for "
                     "%d x %d pixels",
                     (long long)st.st_size, (int)r->width, (int)r->height);
}

bool sky_helper_decode(int fd, struct sky_pixels *out, struct error *err)
{
    *out = (struct sky_pixels){0};
    struct child c = {.out = -1, .report = -1};
    bool ok = child_start(&c, fd, err);
    if (ok) {
        struct report r = {0};
        bool late;
        size_t got = read_report(&c, &r, sizeof r, &late);
        int status = reap(&c, &late);
        r.error.code[sizeof r.error.code - 1] = 0;
        r.error.name[sizeof r.error.name - 1] = 0;
        r.error.text[sizeof r.error.text - 1] = 0;
        ok = judge(&r, got, status, late, err) && fetch(c.out, &r, out, err);
    }
    if (c.report >= 0)
        close(c.report);
    if (c.out >= 0)
        close(c.out);
    return ok;
}
