// reference_path.c - many paths from given places, their means and variances.
// Work is cut into chunks of a fixed number of paths, put together in order:
// so the number of cores changes nothing.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/reference_private.h"
#include "renderer/shoot_threads.h"
#include "renderer/timer.h"

enum { CHUNK = 16, ROUND = 8192 }; // paths

enum { SINGLE, MULTIPLE, WHOLE, KINDS };

struct chunk {
    int n;
    double mean[KINDS][3], m2[KINDS][3]; // m2: sum of squared differences
    double bounce[REFERENCE_BOUNCES][3], events; // sums
};

struct round {
    const struct reference *s;
    const struct places_item *place;
    const struct reference_paths *how;
    size_t count;        // places
    int first;           // number of a place's first chunk in this round
    struct chunk *chunk; // [chunks * places]
};

static void take(struct chunk *c, const struct reference_walk *w)
{
    double x[KINDS][3] = {{0}};
    for (int n = 0; n < REFERENCE_BOUNCES; n++)
        for (int k = 0; k < 3; k++) {
            x[n ? MULTIPLE : SINGLE][k] += w->bounce[n][k];
            x[WHOLE][k] += w->bounce[n][k];
            c->bounce[n][k] += w->bounce[n][k];
        }
    c->n++;
    c->events += w->length;
    for (int q = 0; q < KINDS; q++)
        for (int k = 0; k < 3; k++) {
            const double off = x[q][k] - c->mean[q][k];
            c->mean[q][k] += off / c->n;
            c->m2[q][k] += off * (x[q][k] - c->mean[q][k]);
        }
}

// Chan, Golub and LeVeque 1979.
static void join(struct chunk *a, const struct chunk *b)
{
    const double n = a->n + b->n;
    for (int q = 0; q < KINDS; q++)
        for (int k = 0; k < 3; k++) {
            const double off = b->mean[q][k] - a->mean[q][k];
            a->mean[q][k] += off * b->n / n;
            a->m2[q][k] += b->m2[q][k] + off * off * a->n * b->n / n;
        }
    for (int i = 0; i < REFERENCE_BOUNCES; i++)
        for (int k = 0; k < 3; k++)
            a->bounce[i][k] += b->bounce[i][k];
    a->events += b->events;
    a->n += b->n;
}

static void work(void *context, size_t i)
{
    const struct round *r = context;
    const size_t place = i % r->count;
    const int chunk = r->first + (int)(i / r->count);
    struct reference_vertex v;
    struct reference_walk w = {
        .scene = r->s, .flags = r->how->flags, .events = r->how->events};
    reference_vertex_at(r->s, &r->place[place], &v);
    memset(&r->chunk[i], 0, sizeof r->chunk[i]);
    for (int k = chunk * CHUNK; k < (chunk + 1) * CHUNK && k < r->how->samples;
         k++) {
        reference_random_begin(&w.random, r->how->seed, place, (uint64_t)k);
        reference_walk_run(&w, &v);
        take(&r->chunk[i], &w);
    }
}

static void settle(const struct chunk *c, struct reference_estimate *e)
{
    const double n = c->n, share = n > 1 ? 1 / (n * (n - 1)) : INFINITY;
    memset(e, 0, sizeof *e);
    e->samples = c->n;
    e->events = c->events / n;
    for (int k = 0; k < 3; k++) {
        e->single[k] = c->mean[SINGLE][k];
        e->multiple[k] = c->mean[MULTIPLE][k];
        e->whole[k] = c->mean[WHOLE][k];
        e->single_variance[k] = c->m2[SINGLE][k] * share;
        e->multiple_variance[k] = c->m2[MULTIPLE][k] * share;
        e->whole_variance[k] = c->m2[WHOLE][k] * share;
    }
    for (int i = 0; i < REFERENCE_BOUNCES; i++)
        for (int k = 0; k < 3; k++)
            e->bounce[i][k] = c->bounce[i][k] / n;
}

static bool tell(const struct reference_paths *how, int done, double began)
{
    if (!how->progress)
        return true;
    struct reference_progress p = {
        .samples = done < how->samples ? done : how->samples};
    p.share = (double)p.samples / how->samples;
    p.seconds_left = (timer_now() - began) * (1 / p.share - 1);
    return how->progress(how->self, &p);
}

bool reference_path(const struct reference *s, const struct places_item *place,
                    size_t count, const struct reference_paths *how,
                    struct reference_estimate *out)
{
    if (count == 0)
        return true;
    const int chunks = (how->samples + CHUNK - 1) / CHUNK;
    const int most = (int)(1 + ROUND / (CHUNK * count));
    const double began = timer_now();
    struct round r = {s, place, how, count, 0, NULL};
    struct chunk *sum = bytes_zalloc(count, sizeof *sum);
    bool on = true;
    r.chunk = bytes_alloc((size_t)most * count * sizeof *r.chunk);
    while (on && r.first < chunks) {
        const int n = chunks - r.first < most ? chunks - r.first : most;
        shoot_threads((size_t)n * count, work, &r);
        for (size_t i = 0; i < (size_t)n * count; i++)
            join(&sum[i % count], &r.chunk[i]);
        r.first += n;
        on = tell(how, r.first * CHUNK, began);
    }
    for (size_t i = 0; i < count; i++)
        settle(&sum[i], &out[i]);
    free(r.chunk);
    free(sum);
    return on || r.first >= chunks;
}
