// test_sky_helper.c - what a decoding helper may do to the program: nothing.
// Crashes, hangs, kills and lies of a helper are staged by this very program:
// it is what sky_load starts, so main can misbehave before sky_helper_main.
#include "renderer/sky.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>

#include "renderer/sky_helper.h"
#include "tests/check.h"
#include "tests/unit/sky_files.h"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// A flat Radiance file.
static void small_file(struct buf *b)
{
    buf_text(b, "#?RADIANCE\n\n-Y 2 +X 4\n");
    for (int i = 0; i < 8; i++)
        buf_append(b, "\x80\x80\x80\x81", 4);
}

static void misbehave(const char *how)
{
    if (strcmp(how, "crash") == 0) {
        signal(SIGSEGV, SIG_DFL); // a sanitizer's handler would report it
        raise(SIGSEGV);
    } else if (strcmp(how, "hang") == 0) {
        for (;;)
            pause();
    } else if (strcmp(how, "kill") == 0) {
        raise(SIGKILL);
    } else if (strcmp(how, "exit") == 0) {
        _exit(0);
    } else if (strcmp(how, "closed") == 0) { // reports nothing, goes on
        close(5);
        for (;;)
            pause();
    } else if (strcmp(how, "lie") == 0) {
        // A whole report that claims more pixels than it hands over.
        struct {
            uint32_t magic;
            int32_t ok, width, height;
            struct error error;
        } r = {0x474c5359, 1, 64, 32, {{0}, {0}, {0}}};
        if (write(4, "short", 5) == 5 && write(5, &r, sizeof r) == sizeof r)
            _exit(0);
    } else if (strcmp(how, "garbage") == 0) {
        char junk[1000];
        memset(junk, 'x', sizeof junk);
        if (write(5, junk, sizeof junk) > 0)
            _exit(0);
    }
}

struct staged {
    const char *how, *words;
    double at_least, at_most; // seconds
};

static void stage(const char *path, const struct staged *s)
{
    struct error err = {0};
    char name[40];
    snprintf(name, sizeof name, "helper: %s", s->how);
    check_case(name);
    setenv("GLINT_TEST_HELPER", s->how, 1);
    double begin = now();
    struct sky_map *m = sky_load(path, &err);
    double seconds = now() - begin;
    unsetenv("GLINT_TEST_HELPER");
    CHECK(m == NULL);
    sky_map_destroy(m);
    if (!CHECK(strstr(err.text, s->words) != NULL))
        printf("  error: %s\n", err.text);
    CHECK(seconds >= s->at_least);
    CHECK_ATMOST(seconds, s->at_most);
}

static void test_staged(void)
{
    static const struct staged all[] = {
        {"crash", "crashed on it (signal 11)", 0, 4},
        {"kill", "crashed on it (signal 9)", 0, 4},
        {"exit", "the decoder failed", 0, 4},
        {"garbage", "the decoder failed", 0, 4},
        {"lie", "returned 5 bytes for 64 x 32", 0, 4},
        // Stopped after 5 s; one more for a busy machine.
        {"hang", "longer than 5 s", 4.9, 6.5},
        {"closed", "longer than 5 s", 4.9, 6.5},
    };
    struct buf b = {0};
    small_file(&b);
    char path[64];
    snprintf(path, sizeof path, "%s", sky_files_write(b.data, b.size));
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        stage(path, &all[i]);
    check_case("helper: well again");
    struct error err = {0};
    struct sky_map *m = sky_load(path, &err);
    CHECK(m != NULL);
    sky_map_destroy(m);
    unlink(path);
    buf_finish(&b);
}

// Nothing is left behind: no descriptor, no child.
static int open_descriptors(void)
{
    int n = 0;
    for (int fd = 0; fd < 256; fd++)
        n += fcntl(fd, F_GETFD) != -1;
    return n;
}

static void *load_many(void *path)
{
    int failed = 0;
    for (int i = 0; i < 8; i++) {
        struct sky_map *m = sky_load(path, NULL);
        failed += m == NULL;
        sky_map_destroy(m);
    }
    return failed ? path : NULL;
}

static void test_threads(void)
{
    struct buf b = {0};
    char path[64];
    check_case("helper: from four threads, leaving nothing behind");
    small_file(&b);
    snprintf(path, sizeof path, "%s", sky_files_write(b.data, b.size));
    int before = open_descriptors();
    pthread_t t[4];
    for (int i = 0; i < 4; i++)
        CHECK(pthread_create(&t[i], NULL, load_many, path) == 0);
    for (int i = 0; i < 4; i++) {
        void *failed;
        pthread_join(t[i], &failed);
        CHECK(failed == NULL);
    }
    CHECK(open_descriptors() == before);
    CHECK(waitpid(-1, NULL, WNOHANG) == -1 && errno == ECHILD);
    unlink(path);
    buf_finish(&b);
}

static int loaded, refused;

static void visit_damaged(const char *path, const char *name)
{
    struct error err = {0};
    double begin = now();
    struct sky_map *m = sky_load(path, &err);
    double seconds = now() - begin;
    bool one_line = m || (err.text[0] && !strchr(err.text, '\n'));
    // The parent's own limit is 5 s; half of one for the rest.
    if (!CHECK(one_line) || !CHECK_ATMOST(seconds, 5.5))
        printf("  %s: %.1f s, \"%s\"\n", name, seconds, err.text);
    m ? loaded++ : refused++;
    sky_map_destroy(m);
}

static void visit_good(const char *path, const char *name)
{
    struct error err = {0};
    struct sky_map *m = sky_load(path, &err);
    bool odd = strncmp(name, "deep", 4) == 0 || strncmp(name, "multip", 6) == 0;
    const char *word = name[0] == 'd' ? "is deep" : "is multipart";
    if (!CHECK(odd ? !m && strstr(err.text, word) : m != NULL))
        printf("  %s: %s\n", name, err.text);
    m ? loaded++ : refused++;
    sky_map_destroy(m);
}

static void test_folder(const char *folder, bool damaged)
{
    char name[60];
    snprintf(name, sizeof name, "all of %s", folder);
    check_case(name);
    const char *dir = sky_files_data(folder);
    if (!dir) {
        check_skip("no data");
        return;
    }
    loaded = refused = 0;
    CHECK(sky_files_each(dir, damaged ? visit_damaged : visit_good) > 0);
    printf("  %s: %d loaded, %d refused\n", folder, loaded, refused);
}

int main(int argc, char **argv)
{
    const char *how = getenv("GLINT_TEST_HELPER");
    if (how && strcmp(argv[0], sky_helper_name) == 0)
        misbehave(how);
    sky_helper_main(argc, argv);
    test_staged();
    test_threads();
    test_folder("exr_damaged", true);
    test_folder("exr_features", false);
    test_folder("env", false);
    return check_end();
}
