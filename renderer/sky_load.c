// sky_load.c - where a sky comes from: a file, whose bytes are copied once, so
// that the hash is of what is decoded, or a built-in picture (sky_studio.c).
#include "renderer/sky.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "protocol/digest.h"
#include "renderer/sky_clean.h"
#include "renderer/sky_helper.h"

enum {
    FILE_MAX = 768 << 20
}; // bytes; the largest map as floats and alpha is
   // 512 MiB

static bool copy_failed(struct error *err)
{
    return error_set(err, "file", "", "%s", strerror(errno));
}

// Copies fd into memory and hashes on the way.
static bool copy_bytes(int fd, int copy, unsigned char sha256[32],
                       struct error *err)
{
    struct digest d;
    digest_begin(&d);
    size_t total = 0, size = 256 << 10;
    unsigned char *chunk = bytes_alloc(size);
    bool ok = true;
    for (ssize_t n = 1; ok && n > 0;) {
        n = read(fd, chunk, size);
        if (n < 0 && errno == EINTR) {
            n = 1;
            continue;
        }
        if (n < 0) {
            ok = copy_failed(err);
            break;
        }
        digest_add(&d, (struct span){chunk, (size_t)n});
        for (ssize_t done = 0; ok && done < n;) {
            ssize_t w = write(copy, chunk + done, (size_t)(n - done));
            if (w < 0 && errno != EINTR)
                ok = copy_failed(err);
            done += w > 0 ? w : 0;
        }
        total += (size_t)n;
        if (total > FILE_MAX)
            ok = error_set(err, "limit", "", "the file is larger than %d bytes",
                           FILE_MAX);
    }
    free(chunk);
    digest_end(&d, sha256);
    return ok;
}

static bool check_kind(int copy, struct error *err)
{
    unsigned char first[4] = {0};
    if (pread(copy, first, sizeof first, 0) < (ssize_t)sizeof first)
        return error_set(err, "file", "", "the file is too short for a sky");
    if (memcmp(first, "\x76\x2f\x31\x01", 4) == 0 ||
        memcmp(first, "#?", 2) == 0)
        return true;
    return error_set(err, "file", "",
                     "neither an OpenEXR nor a Radiance file (it begins with "
                     "%02x %02x %02x %02x)",
                     first[0], first[1], first[2], first[3]);
}

// A sealed copy of the file in memory, or -1.
static int copy_file(const char *path, unsigned char sha256[32],
                     struct error *err)
{
    // Not blocking: opening a pipe that nobody writes must not hang.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    int copy = -1;
    bool ok = false;
    struct stat st;
    if (fd < 0 || fstat(fd, &st) != 0)
        copy_failed(err);
    else if (!S_ISREG(st.st_mode))
        error_set(err, "file", "", "not a regular file");
    else if (st.st_size > FILE_MAX)
        error_set(err, "limit", "",
                  "the file has %lld bytes; at most %d are "
                  "read",
                  (long long)st.st_size, FILE_MAX);
    else if ((copy = memfd_create("glint-sky-file",
                                  MFD_CLOEXEC | MFD_ALLOW_SEALING)) < 0)
        copy_failed(err);
    else
        ok = copy_bytes(fd, copy, sha256, err) && check_kind(copy, err);
    if (ok && fcntl(copy, F_ADD_SEALS,
                    F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) != 0)
        ok = copy_failed(err);
    if (fd >= 0)
        close(fd);
    if (!ok && copy >= 0)
        close(copy);
    return ok ? copy : -1;
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

struct sky_map *sky_load(const char *path, struct error *err)
{
    const char *name = base_name(path);
    struct error why = {0};
    struct sky_map *m = bytes_zalloc(1, sizeof *m);
    strncpy(m->name, name, sizeof m->name - 1);
    int copy = copy_file(path, m->sha256, &why);
    struct sky_pixels p = {0};
    bool ok = copy >= 0 && sky_helper_decode(copy, &p, &why);
    if (copy >= 0)
        close(copy);
    if (!ok) {
        error_set(err, why.code, name, "%.80s: %s", name, why.text);
        sky_map_destroy(m);
        return NULL;
    }
    m->width = p.width;
    m->height = p.height;
    m->rgb = p.rgb;
    sky_clean_run(m->rgb, m->width, m->height, &m->cleaned);
    return m;
}

struct sky_map *sky_open(const char *source, struct error *err)
{
    if (strncmp(source, "builtin:", 8) == 0)
        return sky_builtin(source + 8, err);
    return sky_load(source, err);
}

void sky_map_destroy(struct sky_map *m)
{
    if (!m)
        return;
    free(m->rgb);
    free(m);
}
