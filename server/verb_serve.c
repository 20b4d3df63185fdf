// verb_serve.c - `glintd serve`: puts the rooms together, runs the loop, and
// takes them apart in order when a signal says so.
#include "server/verbs.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "server/cache.h"
#include "server/clock.h"
#include "server/conn.h"
#include "server/listener.h"
#include "server/log.h"
#include "server/options.h"
#include "server/service.h"

enum { END_WAIT_MS = 8000, TOKEN_MIN = 16, TOKEN_MAX = 256 };

struct serve {
    struct options options;
    const char *listen, *unix_path, *token_file, *front;
    struct fronts fronts;
    struct options_list roots, allowed;
    struct assets_roots opened;
    char token[TOKEN_MAX + 2];
    struct loop *loop;
    struct engine *engine;
    struct hub hub;
    struct service service;
    struct listener *tcp, *local;
    struct loop_source signals;
    struct loop_timer drain;
};

static bool parse(struct serve *v, int argc, char **argv, int *status)
{
    const struct options_row rows[] = {
        {"listen", OPTIONS_TEXT, &v->listen, 0, 0, "HOST:PORT",
         "address for browsers and scripts (127.0.0.1:8177; port 0: any)"},
        {"unix", OPTIONS_TEXT, &v->unix_path, 0, 0, "PATH",
         "a Unix socket besides, for this user only"},
        {"root", OPTIONS_LIST, &v->roots, 0, 0, "DIR",
         "directory in which clients may name files; repeatable"},
        {"allow-host", OPTIONS_LIST, &v->allowed, 0, 0, "NAME:PORT",
         "a host by which browsers may reach this; repeatable"},
        {"token-file", OPTIONS_TEXT, &v->token_file, 0, 0, "FILE",
         "clients must give the token that FILE holds"},
        {"front", OPTIONS_TEXT, &v->front, 0, 0, "FILE",
         "what `bench --front` measured on this machine (front.txt in the "
         "cache directory)"},
        {"max-connections", OPTIONS_INT, &v->service.connections_max, 1,
         SERVICE_CONNECTIONS_MAX, "N", "beyond so many, refuse (1024)"},
        {0}};
    const struct options_verb verb = {
        .name = "serve",
        .about = "shows the picture to browsers and scripts until SIGTERM",
        .takes = OPTIONS_SCENE,
        .rows = rows,
    };
    *status = options_parse(&v->options, &verb, argc, argv);
    return *status < 0;
}

// The first line of the file.
static bool read_token(struct serve *v, struct error *err)
{
    if (!v->token_file)
        return true;
    FILE *f = fopen(v->token_file, "r");
    if (!f)
        return error_set(err, "file", v->token_file, "--token-file %s: %s",
                         v->token_file, strerror(errno));
    char *got = fgets(v->token, sizeof v->token, f);
    fclose(f);
    size_t n = got ? strcspn(v->token, "\r\n") : 0;
    v->token[n] = 0;
    bool plain = strspn(v->token, "abcdefghijklmnopqrstuvwxyz"
                                  "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                  "0123456789-_.~") == n;
    if (n < TOKEN_MIN || n > TOKEN_MAX || !plain)
        return error_set(err, "range", v->token_file,
                         "--token-file %s: wants %d to %d letters, digits or "
                         "-_.~ on its first line",
                         v->token_file, TOKEN_MIN, TOKEN_MAX);
    return true;
}

static void wake(void *ctx)
{
    loop_wake(ctx);
}

static void woken(void *ctx)
{
    hub_events(ctx);
}

static bool start_engine(struct serve *v, struct error *err)
{
    struct engine_setup setup = {.params = v->options.params,
                                 .roots = &v->opened,
                                 .wake = wake,
                                 .ctx = v->loop};
    for (int i = 0; i < v->roots.count; i++)
        if (!assets_roots_add(&v->opened, v->roots.item[i], err))
            return false;
    setup.opening = opening_begin(v->options.hair, v->options.env);
    char *cache = cache_directory();
    setup.cache_dir = cache;
    v->engine = engine_create(&setup, err);
    free(cache);
    return v->engine != NULL;
}

static bool allow_hosts(struct serve *v, struct error *err)
{
    int port = listener_port(v->tcp);
    static const char *const own[] = {"127.0.0.1:%d", "localhost:%d",
                                      "[::1]:%d"};
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++) {
        char host[64];
        snprintf(host, sizeof host, own[i], port);
        if (!service_allow(&v->service, host, err))
            return false;
    }
    for (int i = 0; i < v->allowed.count; i++)
        if (!service_allow(&v->service, v->allowed.item[i], err))
            return false;
    return true;
}

// --- the end ----------------------------------------------------------------
static void drained(struct loop_timer *t)
{
    struct serve *v =
        (struct serve *)((char *)t - offsetof(struct serve, drain));
    loop_stop(v->loop);
}

static void signalled(struct loop_source *s, uint32_t events)
{
    struct serve *v =
        (struct serve *)((char *)s - offsetof(struct serve, signals));
    struct signalfd_siginfo info;
    (void)events;
    if (read(s->fd, &info, sizeof info) <= 0 || v->service.stopping)
        return;
    v->service.stopping = true;
    v->hub.stopping = true;
    listener_destroy(v->tcp);
    listener_destroy(v->local);
    v->tcp = v->local = NULL;
    if (v->service.connections == 0)
        loop_stop(v->loop);
    loop_timer_set(v->loop, &v->drain,
                   clock_us() + SERVICE_DRAIN_S * INT64_C(1000000));
    for (struct conn *c = v->service.conns, *next; c; c = next) {
        next = conn_next(c);
        conn_good_bye(c);
    }
}

static bool watch_signals(struct serve *v, struct error *err)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    signal(SIGPIPE, SIG_IGN);
    // Before any thread begins, so that all of them block these.
    sigprocmask(SIG_BLOCK, &set, NULL);
    v->signals.fd = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    v->signals.ready = signalled;
    v->drain.fire = drained;
    if (v->signals.fd >= 0 && loop_watch(v->loop, &v->signals, EPOLLIN))
        return true;
    return error_set(err, "system", "", "no signals: %s", strerror(errno));
}

static void take_apart(struct serve *v)
{
    while (v->service.conns)
        conn_destroy(v->service.conns);
    listener_destroy(v->tcp);
    listener_destroy(v->local);
    // A driver that compiles or a fit that is under way cannot be broken off;
    // nothing of it outlives the process.
    if (v->engine && !engine_stop(v->engine, END_WAIT_MS))
        _exit(0);
    hub_finish(&v->hub);
    fronts_finish(&v->fronts);
    engine_destroy(v->engine);
    if (v->signals.fd >= 0)
        close(v->signals.fd);
    loop_destroy(v->loop);
    service_finish(&v->service);
    assets_roots_finish(&v->opened);
}

// --- the whole --------------------------------------------------------------
static bool start(struct serve *v, struct error *err)
{
    v->loop = loop_create(err);
    if (!v->loop || !read_token(v, err) || !watch_signals(v, err))
        return false;
    struct listener_address address = {v->listen, v->token[0] != 0};
    v->service.loop = v->loop;
    v->service.hub = &v->hub;
    // Bound before the long work, so that a port in use is told at once.
    v->tcp = listener_tcp(&v->service, address, err);
    if (!v->tcp || !allow_hosts(v, err))
        return false;
    if (v->unix_path) {
        v->local = listener_unix(&v->service, v->unix_path, err);
        if (!v->local)
            return false;
    }
    if (!fronts_open(&v->fronts, v->front, err) || !start_engine(v, err))
        return false;
    hub_init(&v->hub, v->loop, v->engine, &v->options.params, &v->fronts);
    v->fronts = (struct fronts){0};
    v->hub.token = v->token[0] ? v->token : NULL;
    loop_on_wake(v->loop, woken, &v->hub);
    return true;
}

int verb_serve_run(int argc, char **argv)
{
    struct serve v = {.listen = "127.0.0.1:8177",
                      .service.connections_max = SERVICE_CONNECTIONS_MAX,
                      .signals.fd = -1};
    struct error err = {0};
    int status;
    if (parse(&v, argc, argv, &status)) {
        prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
        bool ok = start(&v, &err);
        if (ok) {
            printf("listening http://%s/\n", listener_name(v.tcp));
            fflush(stdout);
            ok = loop_run(v.loop, &err);
        }
        take_apart(&v);
        status = ok ? 0 : options_fail(&err);
        if (!ok && strcmp(err.code, "syntax") == 0)
            status = 2; // of an option's text
    }
    options_list_finish(&v.roots);
    options_list_finish(&v.allowed);
    options_finish(&v.options);
    return status;
}
