// guards.c - see the header.
#include "tests/extremes/guards.h"

#include <stdio.h>
#include <string.h>

#include "renderer/embed.h"

bool guards_read(struct guards_row row[GUARDS_MAX])
{
    struct span text = embed_shader("guard.glsl");
    const char *at = (const char *)text.data, *end = at + text.size;
    int found = 0;
    memset(row, 0, GUARDS_MAX * sizeof *row);
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        char line[256], name[40], what[96];
        int id;
        snprintf(line, sizeof line, "%.*s", (int)((stop ? stop : end) - at),
                 at);
        at = stop ? stop + 1 : end;
        if (sscanf(line, "const int GUARD_%39[A-Z0-9_] = %d; // %95[^\n]", name,
                   &id, what) != 3)
            continue;
        if (id < 0 || id >= GUARDS_MAX || row[id].name[0])
            return false;
        snprintf(row[id].name, sizeof row[id].name, "%s", name);
        snprintf(row[id].what, sizeof row[id].what, "%s", what);
        found++;
    }
    return found > 0;
}

void guards_count(const uint32_t *hits, size_t count, long sum[GUARDS_MAX])
{
    for (size_t i = 0; i < count; i++)
        for (int g = 0; g < GUARDS_MAX; g++)
            sum[g] += guards_hit(hits + PROBE_GUARD_WORDS * i, g);
}
