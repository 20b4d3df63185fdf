// timer.c - timestamp queries around stages.
#include "renderer/timer.h"

#include <string.h>
#include <time.h>

#include "renderer/gl.h"

void timer_init(struct timer *t)
{
    memset(t, 0, sizeof *t);
    gl.CreateQueries(GL_TIMESTAMP, 2 * TIMER_SLOTS, t->query);
}

void timer_finish(struct timer *t)
{
    if (t->query[0])
        gl.DeleteQueries(2 * TIMER_SLOTS, t->query);
    memset(t, 0, sizeof *t);
}

void timer_begin(struct timer *t, int slot, const char *name)
{
    gl.PushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, (GLuint)slot, -1, name);
    gl.QueryCounter(t->query[2 * slot], GL_TIMESTAMP);
}

void timer_end(struct timer *t, int slot)
{
    gl.QueryCounter(t->query[2 * slot + 1], GL_TIMESTAMP);
    gl.PopDebugGroup();
    t->used[slot] = true;
}

void timer_collect(struct timer *t, double *ms, int slots)
{
    for (int i = 0; i < slots; i++) {
        if (!t->used[i])
            continue;
        GLuint64 from = 0, to = 0;
        gl.GetQueryObjectui64v(t->query[2 * i], GL_QUERY_RESULT, &from);
        gl.GetQueryObjectui64v(t->query[2 * i + 1], GL_QUERY_RESULT, &to);
        double span = to > from ? (double)(to - from) * 1e-6 : 0;
        ms[i] = (ms[i] > 0 ? ms[i] : 0) + span;
        t->used[i] = false;
    }
}

double timer_now(void)
{
    struct timespec ts;
    clock_gettime(CLOCK_MONOTONIC, &ts);
    return (double)ts.tv_sec + 1e-9 * (double)ts.tv_nsec;
}
