// crew.c - workers asleep behind a condition variable.  Which piece comes next
// is a counter's affair; nobody waits for a worker that did not wake in time.
#include "renderer/crew.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <sys/resource.h>

enum { THREADS_MAX = 64 };

static struct {
    pthread_mutex_t lock;
    pthread_cond_t wake, left;
    bool open;      // there may be pieces nobody has taken
    unsigned round; // a worker joins each once
    int inside;     // workers that work at it
    int most;       // ... that may join it
    void (*work)(void *context, size_t i);
    void *context;
    size_t count;
} job = {.lock = PTHREAD_MUTEX_INITIALIZER,
         .wake = PTHREAD_COND_INITIALIZER,
         .left = PTHREAD_COND_INITIALIZER};
static atomic_size_t next_piece;
static atomic_int limit;
static pthread_mutex_t in_use = PTHREAD_MUTEX_INITIALIZER;
static pthread_once_t once = PTHREAD_ONCE_INIT;
static int workers, level;

int crew_cores(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return 1;
    int n = CPU_COUNT(&set);
    return n < 1 ? 1 : n > THREADS_MAX ? THREADS_MAX : n;
}

void crew_limit(int threads)
{
    atomic_store(&limit, threads);
}

static void toil(void)
{
    for (;;) {
        size_t i =
            atomic_fetch_add_explicit(&next_piece, 1, memory_order_relaxed);
        if (i >= job.count)
            return;
        job.work(job.context, i);
    }
}

static void *worker(void *unused)
{
    unsigned seen = 0;
    pthread_mutex_lock(&job.lock);
    for (;;) {
        while (!job.open || job.round == seen)
            pthread_cond_wait(&job.wake, &job.lock);
        seen = job.round;
        if (job.inside >= job.most)
            continue;
        job.inside++;
        pthread_mutex_unlock(&job.lock);
        toil();
        pthread_mutex_lock(&job.lock);
        if (--job.inside == 0)
            pthread_cond_signal(&job.left);
    }
    return unused;
}

static int priority(void)
{
    return getpriority(PRIO_PROCESS, 0); // of this thread, on Linux
}

// Signals are for the threads that wait for them.  A thread that cannot be had
// only makes it slower.
static void start_all(void)
{
    sigset_t all, before;
    pthread_attr_t attr;
    pthread_t thread;
    if (pthread_attr_init(&attr) != 0)
        return;
    pthread_attr_setdetachstate(&attr, PTHREAD_CREATE_DETACHED);
    level = priority();
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (workers + 1 < crew_cores() &&
           pthread_create(&thread, &attr, worker, NULL) == 0)
        workers++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attr);
}

void crew_start(void)
{
    pthread_once(&once, start_all);
}

static int helpers(size_t count)
{
    if (workers == 0 || priority() > level)
        return 0;
    const int asked = atomic_load(&limit);
    int n = asked > 0 && asked - 1 < workers ? asked - 1 : workers;
    return count < (size_t)n + 1 ? (int)count - 1 : n;
}

static void share(size_t count, void (*work)(void *context, size_t i),
                  void *context, int most)
{
    pthread_mutex_lock(&job.lock);
    job.work = work;
    job.context = context;
    job.count = count;
    job.most = most;
    job.open = true;
    job.round++;
    atomic_store(&next_piece, 0);
    pthread_cond_broadcast(&job.wake);
    pthread_mutex_unlock(&job.lock);
    toil();
    pthread_mutex_lock(&job.lock);
    job.open = false; // who did not wake yet need not
    while (job.inside > 0)
        pthread_cond_wait(&job.left, &job.lock);
    pthread_mutex_unlock(&job.lock);
}

void crew_run(size_t count, void (*work)(void *context, size_t i),
              void *context)
{
    if (count > 1 && pthread_mutex_trylock(&in_use) == 0) {
        crew_start();
        const int most = helpers(count);
        if (most > 0)
            share(count, work, context, most);
        pthread_mutex_unlock(&in_use);
        if (most > 0)
            return;
    }
    for (size_t i = 0; i < count; i++)
        work(context, i);
}
