// sky_files.h - small sky files, made byte by byte for tests, and where the
// real ones lie.
#ifndef TESTS_UNIT_SKY_FILES_H
#define TESTS_UNIT_SKY_FILES_H

#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "renderer/sky.h"

// The folder of real data, or NULL where it is not.
static inline const char *sky_files_data(const char *folder)
{
    static char path[1024];
    const char *root = getenv("GLINT_DATA");
    snprintf(path, sizeof path, "%s/%s", root ? root : "../shared/data",
             folder);
    return access(path, R_OK) == 0 ? path : NULL;
}

// Calls visit for each file of the folder in the order of names.
static inline int sky_files_each(const char *folder,
                                 void (*visit)(const char *path,
                                               const char *name))
{
    struct dirent **list;
    char base[1024], path[2048];
    snprintf(base, sizeof base, "%s", folder);
    int n = scandir(base, &list, NULL, alphasort), seen = 0;
    for (int i = 0; i < n; i++) {
        if (list[i]->d_name[0] != '.') {
            snprintf(path, sizeof path, "%s/%s", base, list[i]->d_name);
            visit(path, list[i]->d_name);
            seen++;
        }
        free(list[i]);
    }
    if (n >= 0)
        free(list);
    return seen;
}

// Writes bytes to a fresh temporary file, whose name it returns.
static inline const char *sky_files_write(const void *data, size_t size)
{
    static char path[64];
    strcpy(path, "/tmp/glint-sky-XXXXXX");
    int fd = mkstemp(path);
    size_t done = 0;
    while (fd >= 0 && done < size) {
        ssize_t n = write(fd, (const char *)data + done, size - done);
        if (n <= 0)
            break;
        done += (size_t)n;
    }
    if (fd >= 0)
        close(fd);
    return path;
}

// The map of a file of these bytes.
static inline struct sky_map *sky_files_load(const struct buf *b,
                                             struct error *err)
{
    const char *path = sky_files_write(b->data, b->size);
    struct sky_map *m = sky_load(path, err);
    unlink(path);
    return m;
}

static inline const float *sky_files_pixel(const struct sky_map *m, int x,
                                           int y)
{
    return m->rgb + 3 * (y * m->width + x);
}

// --- OpenEXR without compression -------------------------------------------

struct sky_files_channel {
    const char *name; // in the order of the alphabet
    int type;         // 0 integer, 1 half, 2 float
    int sampling;     // of both axes
};

struct sky_files_exr {
    int data[4], display[4]; // x0 y0 x1 y1, inclusive
    const struct sky_files_channel *channels;
    int channel_count;
    int envmap;                  // -1: no attribute
    const float *chromaticities; // [8], or NULL
    // Value of a channel at a pixel of the file.
    double (*value)(const char *channel, int x, int y);
};

static inline void sky_files_u32(struct buf *b, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        buf_byte(b, (unsigned char)(v >> 8 * i));
}

static inline void sky_files_f32(struct buf *b, float v)
{
    uint32_t u;
    memcpy(&u, &v, 4);
    sky_files_u32(b, u);
}

// Halves of small dyadic numbers and of infinity only: no rounding here.
static inline uint16_t sky_files_half(double v)
{
    uint32_t u;
    float f = (float)v;
    memcpy(&u, &f, 4);
    uint32_t sign = u >> 16 & 0x8000, e = u >> 23 & 255, m = u >> 13 & 1023;
    if (e == 255)
        return (uint16_t)(sign | 0x7c00 | (m ? 512 : 0));
    if (e <= 112)
        return (uint16_t)sign;
    return (uint16_t)(sign | (e - 112) << 10 | m);
}

static inline void sky_files_head(struct buf *b, const char *name,
                                  const char *type, size_t size)
{
    buf_append(b, name, strlen(name) + 1);
    buf_append(b, type, strlen(type) + 1);
    sky_files_u32(b, (uint32_t)size);
}

static inline void sky_files_header(struct buf *b,
                                    const struct sky_files_exr *e)
{
    struct buf list = {0};
    buf_append(b, "\x76\x2f\x31\x01\x02\0\0\0", 8);
    for (int i = 0; i < e->channel_count; i++) {
        const struct sky_files_channel *c = &e->channels[i];
        buf_append(&list, c->name, strlen(c->name) + 1);
        sky_files_u32(&list, (uint32_t)c->type);
        sky_files_u32(&list, 0);
        sky_files_u32(&list, (uint32_t)c->sampling);
        sky_files_u32(&list, (uint32_t)c->sampling);
    }
    buf_byte(&list, 0);
    sky_files_head(b, "channels", "chlist", list.size);
    buf_append(b, list.data, list.size);
    buf_finish(&list);
    if (e->chromaticities) {
        sky_files_head(b, "chromaticities", "chromaticities", 32);
        for (int i = 0; i < 8; i++)
            sky_files_f32(b, e->chromaticities[i]);
    }
    sky_files_head(b, "compression", "compression", 1);
    buf_byte(b, 0);
    for (int w = 0; w < 2; w++) {
        sky_files_head(b, w ? "displayWindow" : "dataWindow", "box2i", 16);
        for (int i = 0; i < 4; i++)
            sky_files_u32(b, (uint32_t)(w ? e->display : e->data)[i]);
    }
    if (e->envmap >= 0) {
        sky_files_head(b, "envmap", "envmap", 1);
        buf_byte(b, (unsigned char)e->envmap);
    }
    sky_files_head(b, "lineOrder", "lineOrder", 1);
    buf_byte(b, 0);
    sky_files_head(b, "pixelAspectRatio", "float", 4);
    sky_files_f32(b, 1);
    sky_files_head(b, "screenWindowCenter", "v2f", 8);
    sky_files_f32(b, 0);
    sky_files_f32(b, 0);
    sky_files_head(b, "screenWindowWidth", "float", 4);
    sky_files_f32(b, 1);
    buf_byte(b, 0);
}

static inline void sky_files_line(struct buf *b, const struct sky_files_exr *e,
                                  int y)
{
    struct buf line = {0};
    for (int i = 0; i < e->channel_count; i++) {
        const struct sky_files_channel *c = &e->channels[i];
        if (y % c->sampling != 0)
            continue;
        for (int x = e->data[0]; x <= e->data[2]; x++) {
            if (x % c->sampling != 0)
                continue;
            double v = e->value(c->name, x, y);
            uint16_t h = sky_files_half(v);
            if (c->type == 1)
                buf_append(&line, &h, 2);
            else if (c->type == 2)
                sky_files_f32(&line, (float)v);
            else
                sky_files_u32(&line, (uint32_t)v);
        }
    }
    sky_files_u32(b, (uint32_t)y);
    sky_files_u32(b, (uint32_t)line.size);
    buf_append(b, line.data, line.size);
    buf_finish(&line);
}

static inline void sky_files_make_exr(struct buf *b,
                                      const struct sky_files_exr *e)
{
    struct buf body = {0};
    sky_files_header(b, e);
    size_t lines = (size_t)(e->data[3] - e->data[1] + 1);
    for (int y = e->data[1]; y <= e->data[3]; y++) {
        uint64_t at = b->size + 8 * lines - 8 * (size_t)(y - e->data[1]);
        at += body.size; // the table grows by 8 a line until it is whole
        sky_files_u32(b, (uint32_t)at);
        sky_files_u32(b, (uint32_t)(at >> 32));
        sky_files_line(&body, e, y);
    }
    buf_append(b, body.data, body.size);
    buf_finish(&body);
}

#endif
