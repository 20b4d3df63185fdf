// save.c - files that appear whole.  What is in them is the caller's.
#include "protocol/client/save.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// What a signal has to remove.  Set only while the file is not complete.
static char *volatile unfinished;

static void interrupted(int signal_number)
{
    if (unfinished)
        unlink(unfinished);
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

static char *copy(const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(bytes_alloc(size), text, size);
}

static bool failed(struct save *s, struct error *err)
{
    error_set(err, "file", s->path, "cannot write %s: %s", s->path,
              strerror(errno));
    save_abort(s);
    return false;
}

// Beside the place itself, so that the rename stays within one file system.
static bool open_temp(struct save *s)
{
    struct buf name = {0};
    struct sigaction act = {.sa_handler = interrupted};
    const char *slash = strrchr(s->path, '/');
    size_t folder = slash ? (size_t)(slash - s->path) + 1 : 0;
    buf_printf(&name, "%.*s.%s.part-XXXXXX", (int)folder, s->path,
               s->path + folder);
    buf_byte(&name, 0);
    s->temp = (char *)name.data;
    // Before the file exists: mkostemp writes its name where we look for it.
    unfinished = s->temp;
    sigaction(SIGINT, &act, NULL);
    sigaction(SIGTERM, &act, NULL);
    sigaction(SIGHUP, &act, NULL);
    s->fd = mkostemp(s->temp, O_CLOEXEC);
    if (s->fd < 0) {
        unfinished = NULL;
        free(s->temp);
        s->temp = NULL;
        return false;
    }
    // mkstemp makes private files; a picture gets the usual permissions.
    mode_t mask = umask(0);
    umask(mask);
    return fchmod(s->fd, 0666 & ~mask) == 0;
}

bool save_begin(struct save *s, const char *path, struct error *err)
{
    struct stat about;
    bool there = stat(path, &about) == 0;
    *s = (struct save){.fd = -1};
    if (strcmp(path, "-") == 0) {
        s->path = copy("standard output");
        s->fd = dup(STDOUT_FILENO);
        return s->fd >= 0 || failed(s, err);
    }
    // A symbolic link stays one: what it leads to is replaced.
    s->path = there ? realpath(path, NULL) : NULL;
    if (!s->path)
        s->path = copy(path);
    if (there && S_ISDIR(about.st_mode)) {
        errno = EISDIR;
        return failed(s, err);
    }
    if (there && !S_ISREG(about.st_mode)) {
        s->fd = open(s->path, O_WRONLY | O_CLOEXEC);
        return s->fd >= 0 || failed(s, err);
    }
    return open_temp(s) || failed(s, err);
}

bool save_write(struct save *s, struct span bytes, struct error *err)
{
    while (bytes.size > 0) {
        ssize_t n = write(s->fd, bytes.data, bytes.size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return failed(s, err);
        bytes.data += n;
        bytes.size -= (size_t)n;
    }
    return true;
}

static void release(struct save *s)
{
    unfinished = NULL;
    free(s->temp);
    free(s->path);
    *s = (struct save){.fd = -1};
}

bool save_commit(struct save *s, struct error *err)
{
    int fd = s->fd;
    s->fd = -1;
    if (s->temp && fsync(fd) != 0) {
        close(fd);
        return failed(s, err);
    }
    if (close(fd) != 0)
        return failed(s, err);
    if (s->temp && rename(s->temp, s->path) != 0)
        return failed(s, err);
    release(s);
    return true;
}

void save_abort(struct save *s)
{
    if (!s->path)
        return;
    if (s->fd >= 0)
        close(s->fd);
    if (s->temp)
        unlink(s->temp);
    release(s);
}
