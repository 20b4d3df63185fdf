// opening.c - two threads that end by themselves.
#include "server/opening.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

struct load {
    pthread_t thread;
    bool threaded, ok;
    char *name;
    struct error error;
};

struct opening {
    struct load hair_load, sky_load;
    struct assets_hair hair;
    struct assets_sky sky;
};

static void *load_hair(void *arg)
{
    struct opening *o = arg;
    struct load *l = &o->hair_load;
    l->ok = assets_hair_load(&o->hair, l->name, NULL, &l->error);
    return NULL;
}

static void *load_sky(void *arg)
{
    struct opening *o = arg;
    struct load *l = &o->sky_load;
    l->ok = assets_sky_load(&o->sky, l->name, NULL, &l->error);
    return NULL;
}

static void begin(struct opening *o, struct load *l, const char *name,
                  void *(*run)(void *))
{
    const size_t size = strlen(name) + 1;
    l->name = memcpy(bytes_alloc(size), name, size);
    l->threaded = pthread_create(&l->thread, NULL, run, o) == 0;
    if (!l->threaded)
        run(o);
}

struct opening *opening_begin(const char *hair, const char *sky)
{
    struct opening *o = bytes_zalloc(1, sizeof *o);
    begin(o, &o->hair_load, hair, load_hair);
    begin(o, &o->sky_load, sky, load_sky);
    return o;
}

static void wait_for(struct load *l)
{
    if (l->threaded)
        pthread_join(l->thread, NULL);
    l->threaded = false;
}

bool opening_wait(struct opening *o, struct error *err)
{
    wait_for(&o->hair_load);
    wait_for(&o->sky_load);
    if (o->hair_load.ok && o->sky_load.ok)
        return true;
    *err = o->hair_load.ok ? o->sky_load.error : o->hair_load.error;
    return false;
}

struct assets_hair *opening_hair(struct opening *o)
{
    return &o->hair;
}

struct assets_sky *opening_sky(struct opening *o)
{
    return &o->sky;
}

void opening_end(struct opening *o)
{
    if (!o)
        return;
    wait_for(&o->hair_load);
    wait_for(&o->sky_load);
    assets_hair_finish(&o->hair);
    assets_sky_finish(&o->sky);
    free(o->hair_load.name);
    free(o->sky_load.name);
    free(o);
}
