// cache.c - finds and makes the cache directory.
#include "server/cache.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "protocol/bytes.h"

// Makes path and what lies above it.
static int make_all(char *path)
{
    for (char *at = path + 1; *at; at++)
        if (*at == '/') {
            *at = 0;
            int bad = mkdir(path, 0700) != 0 && errno != EEXIST;
            *at = '/';
            if (bad)
                return -1;
        }
    return mkdir(path, 0700) != 0 && errno != EEXIST ? -1 : 0;
}

char *cache_directory(void)
{
    const char *own = getenv("GLINT_CACHE"), *xdg = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME");
    struct buf path = {0};
    if (own && *own)
        buf_printf(&path, "%s%c", own, 0);
    else if (xdg && *xdg)
        buf_printf(&path, "%s/glint%c", xdg, 0);
    else if (home && *home)
        buf_printf(&path, "%s/.cache/glint%c", home, 0);
    if (path.size == 0 || make_all((char *)path.data) != 0) {
        buf_finish(&path);
        return NULL;
    }
    return (char *)path.data;
}
