// service.c - the lists of hosts and origins.
#include "server/service.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

static char *joined(const char *a, const char *b)
{
    struct buf text = {0};
    buf_printf(&text, "%s%s%c", a, b, 0);
    return (char *)text.data;
}

bool service_allow(struct service *s, const char *host, struct error *err)
{
    if (!*host || strpbrk(host, " /\"\\"))
        return error_set(err, "syntax", host,
                         "--allow-host %s: expected NAME:PORT", host);
    if (s->host_count == SERVICE_NAMES_MAX)
        return error_set(err, "limit", host,
                         "--allow-host %s: more than %d hosts", host,
                         SERVICE_NAMES_MAX);
    s->hosts[s->host_count++] = joined("", host);
    s->origins[s->origin_count++] = joined("http://", host);
    s->origins[s->origin_count++] = joined("https://", host);
    return true;
}

void service_finish(struct service *s)
{
    for (int i = 0; i < s->host_count; i++)
        free(s->hosts[i]);
    for (int i = 0; i < s->origin_count; i++)
        free(s->origins[i]);
    s->host_count = s->origin_count = 0;
}
