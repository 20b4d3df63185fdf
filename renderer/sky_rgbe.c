// sky_rgbe.c - reads Radiance pictures (Ward, "Real Pixels", Graphics Gems II;
// Radiance's own file format page): flat, old and new run lengths, all eight
// orientations.  EXPOSURE, COLORCORR, GAMMA and PRIMARIES lines are ignored, as
// most programs do, so that a sky is as bright here as there; XYZE is refused.
#include "renderer/sky_pixels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct cursor {
    const unsigned char *at, *end;
};

struct layout { // where the picture's first pixel lies and how it goes on
    int lines, length;      // scan lines, pixels in each
    bool columns;           // scan lines are columns of the picture
    bool line_up, along_up; // they go with rising y or falling x
};

static bool bad(struct error *err, const char *what)
{
    return error_set(err, "file", "", "damaged Radiance file: %s", what);
}

// The next line without its newline, at most 255 characters of it.
static bool next_line(struct cursor *c, char line[256])
{
    if (c->at == c->end)
        return false;
    const unsigned char *end = memchr(c->at, '\n', (size_t)(c->end - c->at));
    if (!end)
        return false;
    size_t n = (size_t)(end - c->at);
    if (n > 0 && c->at[n - 1] == '\r')
        n--;
    if (n > 255)
        n = 255;
    memcpy(line, c->at, n);
    line[n] = 0;
    c->at = end + 1;
    return true;
}

static bool read_header(struct cursor *c, struct error *err)
{
    char line[256];
    if (!next_line(c, line) || strncmp(line, "#?", 2) != 0)
        return bad(err, "it does not begin with #?");
    for (int lines = 0; next_line(c, line); lines++) {
        if (line[0] == 0)
            return true;
        if (lines > 1000)
            break;
        if (strncmp(line, "FORMAT=", 7) != 0)
            continue;
        if (strcmp(line + 7, "32-bit_rle_xyze") == 0)
            return error_set(err, "file", "",
                             "the Radiance file holds XYZE colours; convert it "
                             "to RGBE");
        if (strcmp(line + 7, "32-bit_rle_rgbe") != 0)
            return error_set(err, "file", "",
                             "the Radiance file's format is '%.80s'; "
                             "32-bit_rle_rgbe is read",
                             line + 7);
    }
    return bad(err, "its header has no end");
}

// "-Y 512 +X 1024": the first axis is the one between scan lines.
static bool read_layout(struct cursor *c, struct layout *l, struct error *err)
{
    char line[256], axis[2][3];
    long size[2];
    if (!next_line(c, line))
        return bad(err, "it has no resolution line");
    if (sscanf(line, "%2s %6ld %2s %6ld", axis[0], &size[0], axis[1],
               &size[1]) != 4)
        return error_set(err, "file", "",
                         "damaged Radiance file: its resolution line is "
                         "'%.80s'",
                         line);
    for (int i = 0; i < 2; i++)
        if ((axis[i][0] != '+' && axis[i][0] != '-') ||
            (axis[i][1] != 'X' && axis[i][1] != 'Y') || size[i] < 1 ||
            size[i] > SKY_SIDE_MAX || axis[0][1] == axis[1][1])
            return error_set(err, "file", "",
                             "damaged Radiance file: its resolution line is "
                             "'%.80s'",
                             line);
    l->lines = (int)size[0];
    l->length = (int)size[1];
    l->columns = axis[0][1] == 'X';
    const char *x = l->columns ? axis[0] : axis[1];
    const char *y = l->columns ? axis[1] : axis[0];
    l->line_up = l->columns ? x[0] == '-' : y[0] == '+';
    l->along_up = l->columns ? y[0] == '+' : x[0] == '-';
    return true;
}

// New run lengths: each of the four components for itself, after the marker.
static bool read_planes(struct cursor *c, unsigned char *line, int length)
{
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < length;) {
            if (c->end - c->at < 2)
                return false;
            int n = *c->at++;
            if (n > 128) {
                n -= 128;
                if (n > length - i)
                    return false;
                for (; n > 0; n--)
                    line[4 * i++ + k] = *c->at;
                c->at++;
            } else {
                if (n == 0 || n > length - i || c->end - c->at < n)
                    return false;
                for (; n > 0; n--)
                    line[4 * i++ + k] = *c->at++;
            }
        }
    return true;
}

// Flat pixels, among which 1 1 1 n repeats the one before n times; a second
// such pixel in a row counts 256 n, and so on.
static bool read_old(struct cursor *c, unsigned char *line, int length)
{
    int shift = 0;
    for (int i = 0; i < length;) {
        if (c->end - c->at < 4)
            return false;
        if (c->at[0] == 1 && c->at[1] == 1 && c->at[2] == 1) {
            if (i == 0 || shift > 16)
                return false;
            long n = (long)c->at[3] << shift;
            if (n > length - i)
                return false;
            for (; n > 0; n--, i++)
                memcpy(line + 4 * i, line + 4 * (i - 1), 4);
            shift += 8;
        } else {
            memcpy(line + 4 * i++, c->at, 4);
            shift = 0;
        }
        c->at += 4;
    }
    return true;
}

static bool read_line(struct cursor *c, unsigned char *line, int length)
{
    if (length >= 8 && length < 32768 && c->end - c->at >= 4 && c->at[0] == 2 &&
        c->at[1] == 2 && c->at[2] < 128) {
        if (c->at[2] * 256 + c->at[3] != length)
            return false;
        c->at += 4;
        return read_planes(c, line, length);
    }
    return read_old(c, line, length);
}

static void store_line(struct sky_pixels *p, const struct layout *l, int number,
                       const unsigned char *line)
{
    for (int i = 0; i < l->length; i++, line += 4) {
        int a = l->line_up ? l->lines - 1 - number : number;
        int b = l->along_up ? l->length - 1 - i : i;
        int x = l->columns ? a : b, y = l->columns ? b : a;
        float *to = p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x);
        float unit = line[3] ? ldexpf(1, line[3] - 136) : 0;
        for (int k = 0; k < 3; k++)
            to[k] = unit * line[k];
    }
}

bool sky_rgbe_read(struct span file, struct sky_pixels *out, struct error *err)
{
    *out = (struct sky_pixels){0};
    struct cursor c = {file.data, file.data + file.size};
    struct layout l = {0};
    if (!read_header(&c, err) || !read_layout(&c, &l, err) ||
        !sky_pixels_create(out, l.columns ? l.lines : l.length,
                           l.columns ? l.length : l.lines, err))
        return false;
    unsigned char *line = bytes_alloc((size_t)l.length * 4);
    bool ok = true;
    for (int n = 0; ok && n < l.lines; n++) {
        ok = read_line(&c, line, l.length);
        if (ok)
            store_line(out, &l, n, line);
        else
            error_set(err, "file", "",
                      "damaged Radiance file: scan line %d of %d", n + 1,
                      l.lines);
    }
    free(line);
    if (!ok)
        sky_pixels_finish(out);
    return ok;
}
