// sky_cache.c - see the header.  The bytes: a line that names format and
// algorithm, the key, the numbers as text that reads back exactly, and the
// SHA-256 of all that.
#include "renderer/sky_cache.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "protocol/digest.h"

// Changes whenever a fit of the same sky would come out differently.
static const int algorithm = 1;

enum { FILE_MAX = 64 << 10, PATH_MAX_HERE = 4096 };

static bool path_of(const char *dir, const struct sky_cache_key *key,
                    char path[PATH_MAX_HERE])
{
    char hex[65];
    digest_hex(key->sha256, sizeof key->sha256, hex);
    int n = snprintf(path, PATH_MAX_HERE, "%s/sky-%s-%d-%d-%d.fit", dir, hex,
                     key->lights, (int)key->mode, algorithm);
    return n > 0 && n < PATH_MAX_HERE;
}

static void head(struct buf *b, const struct sky_cache_key *key)
{
    char hex[65];
    digest_hex(key->sha256, sizeof key->sha256, hex);
    buf_printf(b, "glint sky fit %d\n%s %d %d\n", algorithm, hex, key->lights,
               (int)key->mode);
}

// Hexadecimal floats: exact, and the same in every locale but for the point,
// which is why strtod is not asked to read what was not written here.
static void body(struct buf *b, const struct sky_fit *f)
{
    buf_printf(b, "%d %d %a %a %a %a %a %a\n", f->count, f->iterations,
               f->residual, f->predicted_error, f->energy_ratio[0],
               f->energy_ratio[1], f->energy_ratio[2], f->seconds);
    for (int j = 0; j < f->count; j++) {
        const struct sky_light *l = &f->light[j];
        buf_printf(b, "%a %a %a %a %a %a %a\n", l->direction[0],
                   l->direction[1], l->direction[2], l->lambda, l->radiance[0],
                   l->radiance[1], l->radiance[2]);
    }
}

static bool read_file(const char *path, struct buf *b)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    struct stat st;
    bool ok = fd >= 0 && fstat(fd, &st) == 0 && S_ISREG(st.st_mode) &&
              st.st_size > 0 && st.st_size <= FILE_MAX;
    for (size_t left = ok ? (size_t)st.st_size : 0; ok && left > 0;) {
        ssize_t n = read(fd, buf_grow(b, left), left);
        b->size -= left - (n > 0 ? (size_t)n : 0);
        ok = n > 0 || (n < 0 && errno == EINTR);
        left -= n > 0 ? (size_t)n : 0;
    }
    if (fd >= 0)
        close(fd);
    return ok;
}

// The sum at the end is right, and the head is the one for the key.
static bool check_file(struct buf *b, const struct sky_cache_key *key,
                       char **numbers)
{
    unsigned char sum[32];
    char hex[66];
    if (b->size < 65)
        return false;
    size_t size = b->size - 65;
    digest_sha256((struct span){b->data, size}, sum);
    digest_hex(sum, sizeof sum, hex);
    hex[64] = '\n';
    if (memcmp(b->data + size, hex, 65) != 0)
        return false;
    b->data[size] = 0;
    struct buf want = {0};
    head(&want, key);
    bool ok = want.size < size && memcmp(b->data, want.data, want.size) == 0;
    *numbers = (char *)b->data + want.size;
    buf_finish(&want);
    return ok;
}

static bool number(char **at, double low, double high, double *out)
{
    char *end;
    *out = strtod(*at, &end);
    bool ok = end != *at && *out >= low && *out <= high;
    *at = end;
    return ok;
}

static bool parse_light(char **at, struct sky_light *l)
{
    double norm = 0;
    bool ok = true;
    for (int k = 0; k < 3; k++) {
        ok = ok && number(at, -1.001, 1.001, &l->direction[k]);
        norm += l->direction[k] * l->direction[k];
    }
    ok = ok && fabs(norm - 1) < 1e-9 && number(at, 1e-3, 1e4, &l->lambda);
    for (int k = 0; k < 3; k++)
        ok = ok && number(at, 0, 1e30, &l->radiance[k]);
    return ok;
}

static bool parse(char *at, int lights, struct sky_fit *f)
{
    double count = 0, iterations = 0;
    bool ok = number(&at, 0, lights, &count) &&
              number(&at, 0, 1e6, &iterations) &&
              number(&at, 0, 1e9, &f->residual) &&
              number(&at, 0, 1e9, &f->predicted_error);
    for (int k = 0; k < 3; k++)
        ok = ok && number(&at, 0, 1e9, &f->energy_ratio[k]);
    ok = ok && number(&at, 0, 1e9, &f->seconds);
    f->count = ok ? (int)count : 0;
    f->iterations = (int)iterations;
    for (int j = 0; ok && j < f->count; j++)
        ok = parse_light(&at, &f->light[j]);
    return ok && at[0] == '\n' && at[1] == 0;
}

bool sky_cache_read(const char *dir, const struct sky_cache_key *key,
                    struct sky_fit *fit)
{
    char path[PATH_MAX_HERE], *numbers;
    struct buf b = {0};
    memset(fit, 0, sizeof *fit);
    bool ok = path_of(dir, key, path) && read_file(path, &b) &&
              check_file(&b, key, &numbers) && parse(numbers, key->lights, fit);
    buf_finish(&b);
    if (!ok)
        memset(fit, 0, sizeof *fit);
    fit->from_cache = ok;
    return ok;
}

static bool write_file(int fd, const struct buf *b)
{
    for (size_t done = 0; done < b->size;) {
        ssize_t n = write(fd, b->data + done, b->size - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        done += (size_t)n;
    }
    return true;
}

void sky_cache_write(const char *dir, const struct sky_cache_key *key,
                     const struct sky_fit *fit)
{
    char path[PATH_MAX_HERE], beside[PATH_MAX_HERE + 8], hex[65];
    unsigned char sum[32];
    if (!path_of(dir, key, path))
        return;
    struct buf b = {0};
    head(&b, key);
    body(&b, fit);
    digest_sha256((struct span){b.data, b.size}, sum);
    digest_hex(sum, sizeof sum, hex);
    buf_printf(&b, "%s\n", hex);
    mkdir(dir, 0700);
    snprintf(beside, sizeof beside, "%s.XXXXXX", path);
    int fd = mkostemp(beside, O_CLOEXEC);
    if (fd >= 0) {
        bool ok = write_file(fd, &b);
        ok = close(fd) == 0 && ok && rename(beside, path) == 0;
        if (!ok)
            unlink(beside);
    }
    buf_finish(&b);
}
