// The contact sheet of docs/pictures: four colours of hair, lit from the front
// and from behind, for eyes to judge.
//   bench_sheet [--groom NAME] [--samples N] [--rays N] [--tile WxH] FILE
// FILE ends in .jpg or .png.
// Columns: blond, brown, black, red.  Rows: sun in front, sun behind; the
// studio's sky is left on dimly.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/encode.h"
#include "renderer/renderer.h"

enum { COLUMNS = 4, ROWS = 2 };

// Absorption per radius, linear RGB: what melanin takes, from a little to much.
static const float colours[COLUMNS][3] = {
    {0.04f, 0.09f, 0.20f},
    {0.20f, 0.34f, 0.62f},
    {1.10f, 1.35f, 1.70f},
    {0.09f, 0.34f, 0.80f},
};

struct sheet {
    const char *groom, *out;
    int samples, rays, width, height; // of a tile
};

static void must(bool ok, const struct error *err)
{
    if (!ok) {
        fprintf(stderr, "bench_sheet: %s\n", err->text);
        exit(1);
    }
}

static void describe(struct params *p, const struct sheet *s, int column,
                     int row)
{
    params_defaults(p);
    memcpy(p->fibre.sigma_a, colours[column], sizeof colours[column]);
    p->image.width = s->width;
    p->image.height = s->height;
    p->quality.samples = s->samples;
    p->shadow.rays = s->rays;
    p->camera.fov = 18;
    p->tint.exposure = -0.5f;
    p->sun1.strength = row ? 40 : 24;
    p->sun1.azimuth = row ? 160 : -35;
    p->sun1.elevation = row ? 15 : 20;
    p->view.curve = 1; // a rim is far brighter than the rest
}

static void tile(struct renderer *r, const struct sheet *s, int column, int row,
                 unsigned char *rgba)
{
    struct error err = {0};
    struct params p;
    struct buf pixels = {0};
    bool done = false;
    describe(&p, s, column, row);
    renderer_set_params(r, &p);
    while (!done)
        must(renderer_step(r, &done, &err), &err);
    must(renderer_read_display(r, &pixels, &err), &err);
    const size_t line = 4 * (size_t)s->width;
    for (int y = 0; y < s->height; y++)
        memcpy(rgba + line * ((size_t)(row * s->height + y) * COLUMNS +
                              (size_t)column),
               pixels.data + line * (size_t)y, line);
    buf_finish(&pixels);
}

static void save(const struct sheet *s, const unsigned char *rgba)
{
    const int width = COLUMNS * s->width, height = ROWS * s->height;
    const char *end = strrchr(s->out, '.');
    struct buf bytes = {0};
    if (end && strcmp(end, ".png") == 0)
        encode_png(&bytes, rgba, width, height, false, NULL);
    else
        encode_jpeg(&bytes, rgba, width, height, 85, ENCODE_420);
    FILE *f = fopen(s->out, "wb");
    if (!f || fwrite(bytes.data, 1, bytes.size, f) != bytes.size || fclose(f)) {
        perror(s->out);
        exit(1);
    }
    printf("%s: %d x %d, %zu bytes\n", s->out, width, height, bytes.size);
    buf_finish(&bytes);
}

static void usage(void)
{
    fprintf(stderr, "usage: bench_sheet [--groom NAME] [--samples N] "
                    "[--rays N] [--tile WxH] FILE.jpg|FILE.png\n");
    exit(2);
}

static struct sheet options(int argc, char **argv)
{
    struct sheet s = {"animation", NULL, 16, 1, 280, 320};
    for (int i = 1; i < argc; i++) {
        const bool more = i + 1 < argc;
        if (more && strcmp(argv[i], "--groom") == 0)
            s.groom = argv[++i];
        else if (more && strcmp(argv[i], "--samples") == 0)
            s.samples = atoi(argv[++i]);
        else if (more && strcmp(argv[i], "--rays") == 0)
            s.rays = atoi(argv[++i]);
        else if (more && strcmp(argv[i], "--tile") == 0 &&
                 sscanf(argv[i + 1], "%dx%d", &s.width, &s.height) == 2)
            i++;
        else if (argv[i][0] != '-')
            s.out = argv[i];
        else
            usage();
    }
    if (!s.out || s.samples < 1 || s.samples > 4096 || s.rays < 0 ||
        s.rays > 16 || s.width < 1 || s.height < 1 || s.width > 1024 ||
        s.height > 1024)
        usage();
    return s;
}

int main(int argc, char **argv)
{
    struct error err = {0};
    const struct sheet s = options(argc, argv);
    struct renderer *r = renderer_create(NULL, &err);
    must(r != NULL, &err);
    struct groom *g = groom_builtin(s.groom, &err);
    must(g != NULL && renderer_set_groom(r, g, &err), &err);
    struct sky_map *m = sky_builtin("studio", &err);
    must(m != NULL && renderer_set_sky(r, m, &err), &err);
    unsigned char *rgba = bytes_alloc(4 * (size_t)(COLUMNS * s.width) *
                                      (size_t)(ROWS * s.height));
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++)
            tile(r, &s, column, row, rgba);
    save(&s, rgba);
    free(rgba);
    renderer_destroy(r);
    return 0;
}
