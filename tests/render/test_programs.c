// Programs are compiled once a context: let go of and asked for again they are
// the same, and what is compiled ahead is found.
#include "renderer/program.h"

#include <stdlib.h>

#include "renderer/egl.h"
#include "renderer/gl.h"
#include "renderer/program_pool.h"
#include "tests/check.h"

static const char ADD[] = "accumulate.comp", ADD_KEY[] = "accumulate.comp||";

static struct span line(const char *text)
{
    return (struct span){(const unsigned char *)text, strlen(text)};
}

static void pool(void)
{
    struct error err = {0};
    check_case("what was dropped is found again");
    unsigned a = program_compute(ADD, NULL, &err);
    CHECK(a != 0 && program_pool_compiled() == 1);
    program_drop(a);
    CHECK(program_compute(ADD, NULL, &err) == a);
    CHECK(program_pool_compiled() == 1);
    check_case("two users have two programs");
    unsigned b = program_compute(ADD, NULL, &err);
    CHECK(b != 0 && b != a && program_pool_compiled() == 2);
    check_case("other definitions, another program");
    unsigned layer = program_compute(ADD, "LAYER", &err);
    CHECK(layer != 0 && program_pool_compiled() == 3);
    program_drop(layer);
    program_drop(0);
    check_case("a program compiled ahead is not compiled again");
    CHECK(program_prepare(line("count.comp||"), &err));
    CHECK(program_pool_compiled() == 4 && program_pool_has("count.comp||"));
    CHECK(program_prepare(line("count.comp||"), &err));
    CHECK(program_prepare(line(ADD_KEY), &err)); // in use: not idle, but there
    CHECK(program_compute("count.comp", NULL, &err) != 0);
    CHECK(program_pool_compiled() == 4 && program_pool_count() == 4);
    check_case("the list names all of them");
    struct buf all = {0};
    program_pool_list(&all);
    buf_byte(&all, 0);
    CHECK(strstr((char *)all.data, "accumulate.comp||LAYER\n"));
    CHECK(strstr((char *)all.data, "count.comp||\n"));
    buf_finish(&all);
    check_case("what has no source or no name fails, and is not kept");
    CHECK(!program_prepare(line("nothing.comp||"), &err));
    CHECK(!program_prepare(line("count.comp"), &err));
    CHECK(!program_compute("nothing.comp", NULL, &err));
    CHECK(program_pool_count() == 4);
}

// The least recently dropped give way, those in use never do.
static void room(void)
{
    struct error err = {0};
    char defines[32];
    check_case("idle programs are bounded in number");
    const unsigned used = program_compute("count.comp", "USED", &err);
    for (int i = 0; i < PROGRAM_POOL_IDLE + 8; i++) {
        snprintf(defines, sizeof defines, "N=%d", i);
        program_drop(program_compute("count.comp", defines, &err));
    }
    CHECK(program_pool_count() < PROGRAM_POOL_IDLE + 8);
    CHECK(!program_pool_has("count.comp||N=0"));
    CHECK(program_pool_has("count.comp||USED") && used != 0);
    snprintf(defines, sizeof defines, "count.comp||N=%d", PROGRAM_POOL_IDLE);
    CHECK(program_pool_has(defines));
}

static void sides(void)
{
    check_case("sides and sizes of textures are no powers of two");
    for (int n = 1; n < 5000; n++) {
        const int side = gl_texture_side(n);
        CHECK(side >= n && side <= n + 2 && (side & (side - 1)) != 0);
    }
    for (uint64_t n = 1; n < 200000; n += 7) {
        const uint64_t size = gl_texture_buffer_size(n);
        CHECK(size >= n && size <= n + 512 && (size & (size - 1)) != 0);
        CHECK((size >> 8 & 0xff) != 0);
    }
    for (int k = 4; k < 40; k++) {
        const uint64_t size = gl_texture_buffer_size((uint64_t)1 << k);
        CHECK((size & (size - 1)) != 0 && (size >> 8 & 0xff) != 0);
    }
}

int main(void)
{
    struct error err = {0};
    struct egl *e = egl_create(&err);
    CHECK(e != NULL);
    sides();
    pool();
    room();
    check_case("each context has its own");
    struct egl *other = egl_create(&err);
    CHECK(other && program_pool_count() == 0);
    egl_use(e);
    CHECK(program_pool_count() > 100);
    egl_destroy(other);
    egl_destroy(e);
    return check_end();
}
