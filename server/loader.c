// loader.c - a queue of names and the thread that works through it.
#include "server/loader.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

struct loader {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t work;
    const struct assets_roots *roots;
    void (*done)(void *ctx, struct loader_item *item);
    void *ctx;
    // Under the lock:
    struct loader_item *first; // waiting, oldest first
    struct loader_item *now;   // being loaded
    bool stop, ended;
};

void loader_item_free(struct loader_item *item)
{
    assets_hair_finish(&item->hair);
    assets_sky_finish(&item->sky);
    free(item->name);
    free(item);
}

static void load(const struct loader *l, struct loader_item *item)
{
    item->ok =
        item->which == LOADER_HAIR
            ? assets_hair_load(&item->hair, item->name, l->roots, &item->error)
            : assets_sky_load(&item->sky, item->name, l->roots, &item->error);
}

static void *run(void *arg)
{
    struct loader *l = arg;
    pthread_mutex_lock(&l->lock);
    while (!l->stop) {
        struct loader_item *item = l->first;
        if (!item) {
            pthread_cond_wait(&l->work, &l->lock);
            continue;
        }
        l->first = item->next;
        item->next = NULL;
        l->now = item;
        pthread_mutex_unlock(&l->lock);
        load(l, item);
        pthread_mutex_lock(&l->lock);
        l->now = NULL;
        pthread_mutex_unlock(&l->lock);
        l->done(l->ctx, item);
        pthread_mutex_lock(&l->lock);
    }
    l->ended = true;
    pthread_mutex_unlock(&l->lock);
    return NULL;
}

struct loader *loader_create(const struct assets_roots *roots,
                             void (*done)(void *ctx, struct loader_item *item),
                             void *ctx, struct error *err)
{
    struct loader *l = bytes_zalloc(1, sizeof *l);
    pthread_mutex_init(&l->lock, NULL);
    pthread_cond_init(&l->work, NULL);
    l->roots = roots;
    l->done = done;
    l->ctx = ctx;
    int bad = pthread_create(&l->thread, NULL, run, l);
    if (!bad)
        return l;
    error_set(err, "system", "", "no thread: %s", strerror(bad));
    pthread_cond_destroy(&l->work);
    pthread_mutex_destroy(&l->lock);
    free(l);
    return NULL;
}

void loader_add(struct loader *l, uint64_t id, enum loader_asset which,
                const char *name)
{
    struct loader_item *item = bytes_zalloc(1, sizeof *item);
    size_t size = strlen(name) + 1;
    item->id = id;
    item->which = which;
    item->name = memcpy(bytes_alloc(size), name, size);
    pthread_mutex_lock(&l->lock);
    struct loader_item **at = &l->first;
    while (*at)
        at = &(*at)->next;
    *at = item;
    pthread_cond_signal(&l->work);
    pthread_mutex_unlock(&l->lock);
}

void loader_cancel(struct loader *l, uint64_t id)
{
    pthread_mutex_lock(&l->lock);
    for (struct loader_item **at = &l->first; *at; at = &(*at)->next)
        if ((*at)->id == id) {
            struct loader_item *item = *at;
            *at = item->next;
            loader_item_free(item);
            break;
        }
    if (l->now && l->now->id == id)
        l->now->cancelled = true;
    pthread_mutex_unlock(&l->lock);
}

void loader_stop(struct loader *l)
{
    pthread_mutex_lock(&l->lock);
    l->stop = true;
    pthread_cond_signal(&l->work);
    pthread_mutex_unlock(&l->lock);
}

bool loader_ended(struct loader *l)
{
    pthread_mutex_lock(&l->lock);
    bool ended = l->ended;
    pthread_mutex_unlock(&l->lock);
    return ended;
}

void loader_destroy(struct loader *l)
{
    if (!l)
        return;
    loader_stop(l);
    pthread_join(l->thread, NULL);
    while (l->first) {
        struct loader_item *next = l->first->next;
        loader_item_free(l->first);
        l->first = next;
    }
    pthread_cond_destroy(&l->work);
    pthread_mutex_destroy(&l->lock);
    free(l);
}
