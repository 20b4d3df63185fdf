// Five million strand points, from a .hair file: they load, render and are
// edited.  Only with GLINT_LONG=1.
#include "tests/check.h"
#include "tests/render/scene.h"

#include <stdlib.h>
#include <unistd.h>

#include "tests/bench/grown.h"

enum { STRANDS = 200000, POINTS = 25 };

// A .hair file as docs/FORMATS.md has it: points alone.
static bool write_hair(const char *path, const struct groom *g)
{
    unsigned char head[128] = "HAIR";
    const uint32_t numbers[] = {g->strands, g->points, 2, POINTS - 1};
    const float values[] = {0, 0, 1, 1, 1};
    memcpy(head + 4, numbers, sizeof numbers);
    memcpy(head + 20, values, sizeof values);
    FILE *f = fopen(path, "wb");
    if (!f)
        return false;
    const size_t n = 3 * (size_t)g->points;
    const bool ok = fwrite(head, 1, sizeof head, f) == sizeof head &&
                    fwrite(g->position, sizeof *g->position, n, f) == n;
    return fclose(f) == 0 && ok;
}

static struct groom *through_a_file(void)
{
    char path[] = "/tmp/glint-large-XXXXXX";
    struct error err = {0};
    struct groom *g = grown_groom(STRANDS, POINTS, &err);
    const int fd = mkstemp(path);
    check_case("5 million points load from a file");
    if (!CHECK(g && fd >= 0 && write_hair(path, g)))
        return NULL;
    close(fd);
    const size_t n = 3 * (size_t)g->points;
    struct groom *loaded = groom_load(path, &err);
    unlink(path);
    if (!loaded)
        printf("  %s\n", err.text);
    else
        CHECK(loaded->points == g->points && loaded->strands == g->strands &&
              memcmp(loaded->position, g->position, n * 4) == 0);
    CHECK(loaded != NULL);
    groom_destroy(g);
    return loaded;
}

static void renders(struct groom *g)
{
    struct params p;
    struct renderer_stats s;
    params_defaults(&p);
    p.image.width = 360;
    p.image.height = 240;
    p.quality.samples = 1;
    p.sky.lights = 8;
    check_case("... and render, by rays or with a word why not");
    const size_t points = g->points;
    struct renderer *r = scene_renderer(g, scene_two_lamps(), &p);
    struct buf first = scene_linear(r);
    renderer_stats(r, &s);
    CHECK(s.visible_points > 5000);
    bool told = s.refined;
    for (int i = 0; i < s.left_out_count; i++)
        told |= strcmp(s.left_out[i].what, "shadow_rays") == 0;
    CHECK(told);
    printf("  %s\n", s.refined ? "refined by rays" : "the smooth field");
    CHECK(scene_sum(&first, 3) > 0.05 * 360 * 240);
    printf("  %.1f bytes of GPU memory a point\n",
           (double)s.memory_strands / (double)points);
    // 16 of the point and 4 of its strand's number, and what finds segments:
    // 22 were measured.
    CHECK_ATMOST((double)s.memory_strands / (double)points, 32);
    check_case("... and an edit of the fibre sends no more than of a few");
    p.fibre.sigma_a[0] = 1;
    p.shadow.rays = 0;
    renderer_set_params(r, &p);
    struct buf smooth = scene_linear(r);
    p.fibre.sigma_a[0] = 0.5f;
    renderer_set_params(r, &p);
    struct buf edited = scene_linear(r);
    renderer_stats(r, &s);
    CHECK(s.stage_ms[RENDERER_VISIBLE] < 0 && s.stage_ms[RENDERER_SHADOW] < 0);
    CHECK_ATMOST(s.work.upload_bytes, 239520); // test_edit_cost.c
    CHECK(!scene_same(&smooth, &edited) && !scene_same(&first, &edited));
    buf_finish(&first);
    buf_finish(&smooth);
    buf_finish(&edited);
    renderer_destroy(r);
}

int main(int argc, char **argv)
{
    sky_helper_main(argc, argv);
    if (!getenv("GLINT_LONG")) {
        check_case("five million points");
        check_skip("GLINT_LONG is not set");
        return check_end();
    }
    struct groom *g = through_a_file();
    if (g)
        renders(g);
    return check_end();
}
