// bench_keep.c - one file for each array: the values, then their SHA-256, so
// that half a file or a foreign one is made anew rather than believed.
#include "server/bench_keep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/bytes.h"

static void path_of(const struct bench_keep *k, struct buf *path)
{
    struct digest key = k->key;
    unsigned char sha[32];
    char hex[65];
    digest_end(&key, sha);
    digest_hex(sha, sizeof sha, hex);
    buf_printf(path, "%s/reference-%.32s.bin%c", k->directory, hex, 0);
}

static void digest_of(const double *values, size_t count, unsigned char sha[32])
{
    const struct span bytes = {(const unsigned char *)values,
                               count * sizeof *values};
    digest_sha256(bytes, sha);
}

bool bench_keep_load(const struct bench_keep *k, double *values, size_t count)
{
    struct buf path = {0};
    unsigned char kept[32], found[32];
    if (!k->directory)
        return false;
    path_of(k, &path);
    FILE *f = fopen((const char *)path.data, "rb");
    buf_finish(&path);
    if (!f)
        return false;
    bool ok = fread(values, sizeof *values, count, f) == count &&
              fread(kept, 1, sizeof kept, f) == sizeof kept && fgetc(f) == EOF;
    fclose(f);
    if (!ok)
        return false;
    digest_of(values, count, found);
    return memcmp(kept, found, sizeof kept) == 0;
}

void bench_keep_save(const struct bench_keep *k, const double *values,
                     size_t count)
{
    struct buf path = {0}, part = {0};
    unsigned char sha[32];
    if (!k->directory)
        return;
    path_of(k, &path);
    buf_printf(&part, "%s.%ld%c", (const char *)path.data, (long)getpid(), 0);
    digest_of(values, count, sha);
    FILE *f = fopen((const char *)part.data, "wb");
    if (f) {
        bool ok = fwrite(values, sizeof *values, count, f) == count &&
                  fwrite(sha, 1, sizeof sha, f) == sizeof sha;
        ok = fclose(f) == 0 && ok;
        if (!ok ||
            rename((const char *)part.data, (const char *)path.data) != 0)
            unlink((const char *)part.data);
    }
    buf_finish(&path);
    buf_finish(&part);
}
