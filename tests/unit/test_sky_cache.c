// test_sky_cache.c - fits kept on disk: equal to fresh ones, checked to the
// last bit, never in the way.
#include "renderer/sky.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "protocol/digest.h"
#include "tests/check.h"

static bool same_fit(struct sky_fit a, const struct sky_fit *b)
{
    a.seconds = b->seconds;
    a.from_cache = b->from_cache;
    return memcmp(&a, b, sizeof a) == 0;
}

static struct sky_map *small_map(void)
{
    struct sky_map *m = bytes_zalloc(1, sizeof *m);
    size_t count = 3 * 16 * 8;
    m->width = 16;
    m->height = 8;
    m->rgb = bytes_alloc(count * sizeof *m->rgb);
    for (size_t i = 0; i < count; i++)
        m->rgb[i] = 0.3f + 0.01f * (float)(i % 7);
    digest_sha256(
        (struct span){(unsigned char *)m->rgb, count * sizeof *m->rgb},
        m->sha256);
    return m;
}

static char cache_file[400];

static int find_cache_file(const char *dir)
{
    DIR *d = opendir(dir);
    int n = 0;
    for (struct dirent *e; d && (e = readdir(d));)
        if (e->d_name[0] != '.') {
            snprintf(cache_file, sizeof cache_file, "%.100s/%.250s", dir,
                     e->d_name);
            n++;
        }
    if (d)
        closedir(d);
    return n;
}

static void put(const unsigned char *data, size_t size)
{
    FILE *f = fopen(cache_file, "wb");
    if (f) {
        fwrite(data, 1, size, f);
        fclose(f);
    }
}

static void test_damage(const struct sky_map *m, const char *dir,
                        const struct sky_fit *want)
{
    static unsigned char bytes[65536], bad[65536];
    struct sky_fit got;
    struct error err = {0};
    FILE *f = fopen(cache_file, "rb");
    size_t size = f ? fread(bytes, 1, sizeof bytes, f) : 0;
    if (f)
        fclose(f);
    CHECK(size > 300);
    for (size_t i = 0; i < size + 3; i += i < 200 ? 13 : 61) {
        size_t n = size;
        memcpy(bad, bytes, size);
        if (i < size)
            bad[i] ^= 0x04;
        else
            n = i == size ? 0 : size / 2; // empty; cut
        put(bad, n);
        CHECK(sky_fit_run(m, 3, SKY_FIT_HAIR, dir, &got, &err));
        if (!CHECK(!got.from_cache) || !CHECK(same_fit(got, want)))
            printf("  byte %zu of %zu\n", i, size);
    }
    // What was found damaged was replaced.
    CHECK(sky_fit_run(m, 3, SKY_FIT_HAIR, dir, &got, &err));
    CHECK(got.from_cache);
}

static void test_cache(void)
{
    struct error err = {0};
    struct sky_fit miss, hit, other;
    char dir[] = "/tmp/glint-cache-XXXXXX";
    struct sky_map *m = small_map();
    check_case("cache: a hit equals a miss");
    CHECK(mkdtemp(dir) != NULL);
    CHECK(sky_fit_run(m, 3, SKY_FIT_HAIR, dir, &miss, &err));
    CHECK(sky_fit_run(m, 3, SKY_FIT_HAIR, dir, &hit, &err));
    CHECK(!miss.from_cache && hit.from_cache);
    CHECK(same_fit(hit, &miss));
    CHECK_NEAR(hit.seconds, miss.seconds, 0);
    CHECK(find_cache_file(dir) == 1);
    check_case("cache: damage is noticed");
    test_damage(m, dir, &miss);
    check_case("cache: other settings, other fits");
    CHECK(sky_fit_run(m, 4, SKY_FIT_HAIR, dir, &other, &err));
    CHECK(!other.from_cache);
    CHECK(sky_fit_run(m, 3, SKY_FIT_PLAIN, dir, &other, &err));
    CHECK(!other.from_cache);
    m->sha256[5] ^= 1;
    CHECK(sky_fit_run(m, 3, SKY_FIT_HAIR, dir, &other, &err));
    CHECK(!other.from_cache);
    CHECK(find_cache_file(dir) == 4);
    check_case("cache: a folder that cannot be is no error");
    CHECK(sky_fit_run(m, 3, SKY_FIT_HAIR, "/proc/none/such", &other, &err));
    CHECK(same_fit(other, &miss));
    while (find_cache_file(dir) > 0)
        unlink(cache_file);
    CHECK(rmdir(dir) == 0);
    sky_map_destroy(m);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    test_cache();
    return check_end();
}
