// events.c - see the header.  What an event means is hub.c's affair.
#include "server/events.h"

#include <stdlib.h>

struct events_item {
    struct events_item *next;
    struct engine_event event;
};

static bool replaces(const struct engine_event *new,
                     const struct engine_event *old)
{
    return new->type == ENGINE_FRAME &&
           old->type == ENGINE_FRAME &&still_encoding_same(&new->frame.asked,
                                                           &old->frame.asked);
}

void events_push(struct events *q, const struct engine_event *event)
{
    for (struct events_item *i = q->first; i; i = i->next)
        if (replaces(event, &i->event)) {
            blob_unref(i->event.frame.bytes);
            i->event.frame = event->frame;
            return;
        }
    struct events_item *item = bytes_zalloc(1, sizeof *item);
    item->event = *event;
    if (q->last)
        q->last->next = item;
    else
        q->first = item;
    q->last = item;
}

bool events_take(struct events *q, struct engine_event *out)
{
    struct events_item *item = q->first;
    if (!item)
        return false;
    q->first = item->next;
    if (!q->first)
        q->last = NULL;
    *out = item->event;
    free(item);
    return true;
}

void events_serve(const struct events *q, struct studio_demand *d)
{
    for (const struct events_item *i = q->first; i; i = i->next)
        if (i->event.type == ENGINE_FRAME &&
            still_encoding_same(&i->event.frame.asked, &d->how))
            studio_served(d, &i->event.frame);
}

void events_finish(struct events *q)
{
    struct engine_event event;
    while (events_take(q, &event))
        blob_unref(event.frame.bytes);
}
