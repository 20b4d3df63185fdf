// test_shoot_cut.c - work on strands for rays that gives way to newer work.
#include <stdatomic.h>

#include "renderer/shoot.h"
#include "tests/check.h"

static atomic_int looks;
static bool after(void *ctx)
{
    return atomic_fetch_add(&looks, 1) >= *(const int *)ctx;
}

// Wherever it is cut there is nothing, and nothing is lost (run under
// sanitizers); one that is not cut is what it would be unwatched.
static void test_cut(void)
{
    check_case("shoot is cut");
    struct error err = {0};
    struct params p;
    params_defaults(&p);
    struct groom *g = groom_builtin("ponytail", &err);
    int most = 1 << 30;
    struct watch watch = {.newer = after, .ctx = &most};
    struct shoot *s = shoot_create_watched(g, &p, &watch, &err);
    struct shoot *same = shoot_create(g, &p, &err);
    CHECK(s && same && shoot_bytes(s) == shoot_bytes(same));
    shoot_destroy(s);
    shoot_destroy(same);
    const int all = atomic_load(&looks);
    CHECK(all > 64); // every branch of 2048 pieces and more
    for (int n = 0; n < all; n += 1 + all / 12) {
        atomic_store(&looks, 0);
        atomic_store(&watch.cut, false);
        most = n;
        CHECK(!shoot_create_watched(g, &p, &watch, &err));
        CHECK(err.code[0] == 0);
    }
    groom_destroy(g);
}

int main(void)
{
    test_cut();
    return check_end();
}
