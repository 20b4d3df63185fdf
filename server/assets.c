// assets.c - opens files for the readers of grooms and skies and names them by
// what they hold.  The formats are the renderer's affair.
#include "server/assets.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "protocol/digest.h"

enum { FILE_MAX = 512 << 20 };

struct assets_root {
    char *path; // without a final slash
    int fd;
};

bool assets_roots_add(struct assets_roots *roots, const char *path,
                      struct error *err)
{
    int fd = open(path, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return error_set(err, "file", path, "--root %s: %s", path,
                         strerror(errno));
    size_t count = (size_t)roots->count;
    roots->item = bytes_realloc(roots->item, (count + 1) * sizeof *roots->item);
    size_t size = strlen(path);
    while (size > 1 && path[size - 1] == '/')
        size--;
    char *copy = bytes_alloc(size + 1);
    memcpy(copy, path, size);
    copy[size] = 0;
    roots->item[roots->count++] = (struct assets_root){copy, fd};
    return true;
}

void assets_roots_finish(struct assets_roots *roots)
{
    for (int i = 0; i < roots->count; i++) {
        close(roots->item[i].fd);
        free(roots->item[i].path);
    }
    free(roots->item);
    *roots = (struct assets_roots){0};
}

// --- opening ----------------------------------------------------------------
// The part of `name` behind the root's own path, or `name` where it is
// relative, or NULL.
static const char *below(const struct assets_root *root, const char *name)
{
    if (name[0] != '/')
        return name;
    size_t n = strlen(root->path);
    if (strncmp(name, root->path, n) != 0)
        return NULL;
    name += n;
    if (*name != '/' && root->path[n - 1] != '/')
        return NULL;
    while (*name == '/')
        name++;
    return *name ? name : NULL;
}

static int open_below(const struct assets_roots *roots, const char *name,
                      struct error *err)
{
    if (roots->count == 0) {
        error_set(err, "denied", name,
                  "%s: no directory is open to clients (--root); "
                  "builtin:NAME is",
                  name);
        return -1;
    }
    int why = ENOENT;
    for (int i = 0; i < roots->count; i++) {
        const char *rest = below(&roots->item[i], name);
        if (!rest)
            continue;
        struct open_how how = {.flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK,
                               .resolve =
                                   RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
        long fd =
            syscall(SYS_openat2, roots->item[i].fd, rest, &how, sizeof how);
        if (fd >= 0)
            return (int)fd;
        if (errno != ENOENT)
            why = errno;
    }
    if (why == ENOSYS)
        error_set(err, "denied", name,
                  "%s: this kernel cannot confine a path (openat2)", name);
    else if (why == EXDEV)
        error_set(err, "denied", name,
                  "%s: outside of the directories that "
                  "are open to clients (--root)",
                  name);
    else
        error_set(err, "file", name, "%s: %s", name, strerror(why));
    return -1;
}

// A regular file of at most FILE_MAX bytes, open for reading, or -1.
static int open_named(const struct assets_roots *roots, const char *name,
                      size_t *size, struct error *err)
{
    int fd;
    if (roots) {
        fd = open_below(roots, name, err);
    } else {
        fd = open(name, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
        if (fd < 0)
            error_set(err, "file", name, "%s: %s", name, strerror(errno));
    }
    struct stat st;
    if (fd < 0)
        return -1;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode))
        error_set(err, "file", name, "%s: not a regular file", name);
    else if (st.st_size > FILE_MAX)
        error_set(err, "limit", name,
                  "%s: %lld bytes are more than the allowed %d", name,
                  (long long)st.st_size, FILE_MAX);
    else {
        *size = (size_t)st.st_size;
        return fd;
    }
    close(fd);
    return -1;
}

static bool read_all(int fd, struct buf *to, size_t size, const char *name,
                     struct error *err)
{
    unsigned char *at = buf_grow(to, size);
    for (size_t have = 0; have < size;) {
        ssize_t n = read(fd, at + have, size - have);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return error_set(err, "file", name, "%s: %s", name,
                             n < 0 ? strerror(errno) : "it became shorter");
        have += (size_t)n;
    }
    return true;
}

static const char *without_folders(const char *name)
{
    const char *slash = strrchr(name, '/');
    return slash ? slash + 1 : name;
}

static const char *builtin(const char *name)
{
    return strncmp(name, "builtin:", 8) == 0 ? name + 8 : NULL;
}

// --- hair -------------------------------------------------------------------
static void digest_groom(const struct groom *g, unsigned char out[32])
{
    struct digest d;
    digest_begin(&d);
    digest_add(&d, (struct span){(const unsigned char *)g->first,
                                 (g->strands + 1) * sizeof *g->first});
    digest_add(&d, (struct span){(const unsigned char *)g->position,
                                 3 * sizeof(float) * g->points});
    if (g->diameter)
        digest_add(&d, (struct span){(const unsigned char *)g->diameter,
                                     sizeof(float) * g->points});
    digest_end(&d, out);
}

static struct groom *groom_from_file(const char *name,
                                     const struct assets_roots *roots,
                                     unsigned char sha[32], struct error *err)
{
    size_t size = 0;
    int fd = open_named(roots, name, &size, err);
    if (fd < 0)
        return NULL;
    struct buf file = {0};
    struct groom *g = NULL;
    if (read_all(fd, &file, size, name, err)) {
        struct span bytes = {file.data, file.size};
        digest_sha256(bytes, sha);
        g = groom_parse(bytes, without_folders(name), err);
    }
    buf_finish(&file);
    close(fd);
    return g;
}

bool assets_hair_load(struct assets_hair *h, const char *name,
                      const struct assets_roots *roots, struct error *err)
{
    unsigned char sha[32];
    const char *own = builtin(name);
    *h = (struct assets_hair){0};
    h->groom =
        own ? groom_builtin(own, err) : groom_from_file(name, roots, sha, err);
    if (!h->groom)
        return false;
    if (own)
        digest_groom(h->groom, sha);
    snprintf(h->source.name, sizeof h->source.name, "%s", h->groom->name);
    digest_hex(sha, sizeof sha, h->source.sha256);
    h->strands = h->groom->strands;
    h->points = h->groom->points;
    return true;
}

void assets_hair_finish(struct assets_hair *h)
{
    groom_destroy(h->groom);
    h->groom = NULL;
}

// --- sky --------------------------------------------------------------------
// The reader's error names the path it was given, with or without folders.
static void rename_error(struct error *err, const char *path, const char *name)
{
    const char *known[] = {path, without_folders(path)};
    for (int i = 0; err && i < 2; i++) {
        size_t n = strlen(known[i]);
        if (strncmp(err->text, known[i], n) != 0)
            continue;
        struct error old = *err;
        error_set(err, old.code, name, "%s%s", name, old.text + n);
        return;
    }
}

static struct sky_map *sky_from_file(const char *name,
                                     const struct assets_roots *roots,
                                     struct error *err)
{
    size_t size = 0;
    int fd = open_named(roots, name, &size, err);
    if (fd < 0)
        return NULL;
    struct sky_map *m = NULL;
    if (roots) {
        // The reader wants a path, also in its helper process; this one names
        // the very file that was found to be allowed.
        char path[64];
        snprintf(path, sizeof path, "/proc/%d/fd/%d", (int)getpid(), fd);
        m = sky_load(path, err);
        if (m)
            snprintf(m->name, sizeof m->name, "%s", without_folders(name));
        else
            rename_error(err, path, name);
    } else {
        m = sky_load(name, err);
    }
    close(fd);
    return m;
}

bool assets_sky_load(struct assets_sky *s, const char *name,
                     const struct assets_roots *roots, struct error *err)
{
    const char *own = builtin(name);
    *s = (struct assets_sky){0};
    s->map = own ? sky_builtin(own, err) : sky_from_file(name, roots, err);
    if (!s->map)
        return false;
    snprintf(s->source.name, sizeof s->source.name, "%s", s->map->name);
    digest_hex(s->map->sha256, sizeof s->map->sha256, s->source.sha256);
    s->width = s->map->width;
    s->height = s->map->height;
    return true;
}

void assets_sky_finish(struct assets_sky *s)
{
    sky_map_destroy(s->map);
    s->map = NULL;
}
