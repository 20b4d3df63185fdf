// program_pool.c - an array that is searched: programs are counted in tens, and
// asked for when a variant is chosen, not in every frame.
#include "renderer/program_pool.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

struct entry {
    char key[PROGRAM_POOL_KEY];
    unsigned program;
    bool used;
    uint64_t age; // when it was given back
};

struct program_pool {
    struct entry *entry;
    size_t count, room;
    uint64_t compiled, clock;
    unsigned neutral, black; // program, texture; 0: not asked for yet
};

enum { FIRST_UNIT = 40, UNITS = 16 }; // samplers.comp

static _Thread_local struct program_pool *current;

struct program_pool *program_pool_create(void)
{
    return bytes_zalloc(1, sizeof(struct program_pool));
}

void program_pool_destroy(struct program_pool *pool)
{
    if (!pool)
        return;
    for (size_t i = 0; i < pool->count; i++)
        gl.DeleteProgram(pool->entry[i].program);
    gl.DeleteTextures(1, &pool->black);
    if (current == pool)
        current = NULL;
    free(pool->entry);
    free(pool);
}

void program_pool_use(struct program_pool *pool)
{
    current = pool;
}

static struct entry *find(const char *key, bool idle)
{
    for (size_t i = 0; current && i < current->count; i++) {
        struct entry *e = &current->entry[i];
        if (strcmp(e->key, key) == 0 && !(idle && e->used))
            return e;
    }
    return NULL;
}

bool program_pool_has(const char *key)
{
    return find(key, false) != NULL;
}

unsigned program_pool_take(const char *key)
{
    struct entry *e = find(key, true);
    if (!e)
        return 0;
    e->used = true;
    return e->program;
}

static void make_room(struct program_pool *p)
{
    struct entry *oldest = NULL;
    size_t idle = 0;
    for (size_t i = 0; i < p->count; i++) {
        struct entry *e = &p->entry[i];
        if (e->used)
            continue;
        idle++;
        if (!oldest || e->age < oldest->age)
            oldest = e;
    }
    if (idle > PROGRAM_POOL_IDLE) {
        gl.DeleteProgram(oldest->program);
        *oldest = p->entry[--p->count];
    }
}

void program_pool_add(const char *key, unsigned program, bool used)
{
    struct program_pool *p = current;
    if (!p)
        return;
    if (p->count == p->room) {
        p->room = p->room ? 2 * p->room : 32;
        p->entry = bytes_realloc(p->entry, p->room * sizeof *p->entry);
    }
    struct entry *e = &p->entry[p->count++];
    *e = (struct entry){.program = program, .used = used, .age = ++p->clock};
    snprintf(e->key, sizeof e->key, "%s", key);
    p->compiled++;
    make_room(p);
}

void program_pool_give(unsigned program)
{
    for (size_t i = 0; program && current && i < current->count; i++)
        if (current->entry[i].program == program) {
            current->entry[i].used = false;
            current->entry[i].age = ++current->clock;
            make_room(current);
            return;
        }
    gl.DeleteProgram(program);
}

static bool is_llvmpipe(void)
{
    const GLubyte *name = gl.GetString(GL_RENDERER);
    return name && strstr((const char *)name, "llvmpipe");
}

unsigned program_pool_neutral(void)
{
    struct program_pool *p = current;
    if (!p || p->black)
        return p ? p->neutral : 0;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &p->black);
    if (is_llvmpipe())
        p->neutral = program_compute("samplers.comp", NULL, NULL);
    if (!p->neutral)
        return 0;
    const float zero[4] = {0};
    gl.TextureStorage2D(p->black, 1, GL_RGBA32F, 1, 1);
    gl.TextureParameteri(p->black, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(p->black, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TextureSubImage2D(p->black, 0, 0, 0, 1, 1, GL_RGBA, GL_FLOAT, zero);
    for (GLuint i = 0; i < UNITS; i++)
        gl.BindTextureUnit(FIRST_UNIT + i, p->black);
    return p->neutral;
}

uint64_t program_pool_compiled(void)
{
    return current ? current->compiled : 0;
}

size_t program_pool_count(void)
{
    return current ? current->count : 0;
}

void program_pool_list(struct buf *out)
{
    for (size_t i = 0; current && i < current->count; i++) {
        buf_text(out, current->entry[i].key);
        buf_byte(out, '\n');
    }
}
