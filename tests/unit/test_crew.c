// The crew: every piece once, whoever asks and however many help.
#include "renderer/crew.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#include "tests/check.h"

enum { PIECES = 1000, ASKERS = 4, ROUNDS = 50 };

struct tally {
    atomic_int done[PIECES];
    atomic_int inside, most; // at once
    pthread_t asker;
    atomic_int others; // pieces that another thread than the asker's did
};

static void piece(void *context, size_t i)
{
    struct tally *t = context;
    const int now = atomic_fetch_add(&t->inside, 1) + 1;
    int most = atomic_load(&t->most);
    while (now > most && !atomic_compare_exchange_weak(&t->most, &most, now)) {
    }
    atomic_fetch_add(&t->done[i], 1);
    atomic_fetch_add(&t->others, !pthread_equal(pthread_self(), t->asker));
    atomic_fetch_sub(&t->inside, 1);
}

// Each of the first `count` pieces `times` times, no other, nobody at work.
static bool each(const struct tally *t, size_t count, int times)
{
    bool ok = atomic_load(&t->inside) == 0;
    for (size_t i = 0; i < PIECES; i++)
        ok = ok && atomic_load(&t->done[i]) == (i < count ? times : 0);
    return ok;
}

static void counts(void)
{
    static const size_t sizes[] = {0, 1, 2, 3, 64, PIECES};
    check_case("each piece once");
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        struct tally t = {.asker = pthread_self()};
        crew_run(sizes[k], piece, &t);
        CHECK(each(&t, sizes[k], 1));
        CHECK(atomic_load(&t.most) <= crew_cores());
    }
}

static void slow_piece(void *context, size_t i)
{
    usleep(100);
    piece(context, i);
}

static void limits(void)
{
    check_case("a limit of one leaves all to the caller");
    struct tally t = {.asker = pthread_self()};
    crew_limit(1);
    crew_run(PIECES, piece, &t);
    CHECK(each(&t, PIECES, 1) && atomic_load(&t.others) == 0);
    crew_limit(0);
    check_case("without one the others help");
    // who sleeps leaves the processor: one must wake in 25 ms
    struct tally u = {.asker = pthread_self()};
    for (int k = 0; k < 20 && atomic_load(&u.others) == 0; k++)
        crew_run(256, slow_piece, &u);
    CHECK(crew_cores() == 1 || atomic_load(&u.others) > 0);
}

static void nested_piece(void *context, size_t i)
{
    struct tally *t = context;
    crew_run(10, piece, &t[i]);
}

static void nested(void)
{
    static struct tally t[20];
    bool ok = true;
    check_case("a piece that asks for the crew itself");
    crew_run(20, nested_piece, t);
    for (int i = 0; i < 20; i++)
        ok = ok && each(&t[i], 10, 1);
    CHECK(ok);
}

static void *ask(void *context)
{
    for (int k = 0; k < ROUNDS; k++)
        crew_run(PIECES, piece, context);
    return NULL;
}

static void askers(void)
{
    static struct tally t[ASKERS];
    pthread_t thread[ASKERS];
    check_case("several threads that ask at once");
    for (int i = 0; i < ASKERS; i++)
        CHECK(pthread_create(&thread[i], NULL, ask, &t[i]) == 0);
    for (int i = 0; i < ASKERS; i++)
        pthread_join(thread[i], NULL);
    for (int i = 0; i < ASKERS; i++)
        CHECK(each(&t[i], PIECES, ROUNDS));
}

int main(void)
{
    counts();
    limits();
    nested();
    askers();
    return check_end();
}
