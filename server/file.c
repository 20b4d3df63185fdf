// file.c - see the header.
#include "server/file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

bool file_write(const char *path, const struct buf *bytes, struct error *err)
{
    struct buf name = {0};
    buf_printf(&name, "%s.%ld.part%c", path, (long)getpid(), 0);
    const char *part = (const char *)name.data;
    FILE *f = fopen(part, "wb");
    bool ok = f != NULL;
    if (ok) {
        ok = fwrite(bytes->data, 1, bytes->size, f) == bytes->size;
        ok = fclose(f) == 0 && ok;
        ok = ok && rename(part, path) == 0;
    }
    if (!ok) {
        error_set(err, "file", path, "%s: %s", path, strerror(errno));
        if (f)
            unlink(part);
    }
    buf_finish(&name);
    return ok;
}
