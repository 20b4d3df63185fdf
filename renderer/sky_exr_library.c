// sky_exr_library.c - see the header.  Headers were checked by sky_exr.c
// before; here is only the way through the second library.
#include "renderer/sky_exr_library.h"

#include <ImfCRgbaFile.h>
#include <stdint.h>
#include <stdlib.h>

enum {
    STRIP = 256
}; // lines at a time: the largest block (DWAB), so that
   // nothing is decoded twice and halves stay few

static bool failed(struct error *err)
{
    return error_set(err, "file", "", "damaged OpenEXR file: %.200s",
                     ImfErrorMessage());
}

static void copy_line(const ImfRgba *from, int x0, int y, int width,
                      struct sky_pixels *out)
{
    if (y < 0 || y >= out->height)
        return;
    float *row = out->rgb + 3 * (size_t)y * (size_t)out->width;
    for (int i = 0; i < width; i++) {
        int x = x0 + i;
        if (x < 0 || x >= out->width)
            continue;
        row[3 * x] = ImfHalfToFloat(from[i].r);
        row[3 * x + 1] = ImfHalfToFloat(from[i].g);
        row[3 * x + 2] = ImfHalfToFloat(from[i].b);
    }
}

static bool read_strips(ImfInputFile *in, const struct sky_exr_window *w,
                        const int origin[2], struct sky_pixels *out,
                        struct error *err)
{
    size_t width = (size_t)(w->x1 - w->x0 + 1);
    ImfRgba *strip = bytes_zalloc(width * STRIP, sizeof *strip);
    bool ok = true;
    for (int y = w->y0; ok && y <= w->y1; y += STRIP) {
        int last = w->y1 - y < STRIP ? w->y1 : y + STRIP - 1;
        // The library adds x + y * width to the base; the base itself may lie
        // outside the strip, so it is computed as a number.
        int64_t shift = w->x0 + (int64_t)y * (int64_t)width;
        uintptr_t base =
            (uintptr_t)strip - (uintptr_t)shift * (uintptr_t)sizeof *strip;
        ok = ImfInputSetFrameBuffer(in, (ImfRgba *)base, 1, width) &&
             ImfInputReadPixels(in, y, last);
        if (!ok)
            failed(err);
        for (int i = y; ok && i <= last; i++)
            copy_line(strip + (size_t)(i - y) * width, w->x0 - origin[0],
                      i - origin[1], (int)width, out);
    }
    free(strip);
    return ok;
}

bool sky_exr_library_read(const char *path, const struct sky_exr_window *data,
                          int origin_x, int origin_y, struct sky_pixels *out,
                          struct error *err)
{
    ImfInputFile *in = ImfOpenInputFile(path);
    if (!in)
        return failed(err);
    struct sky_exr_window w;
    ImfHeaderDataWindow(ImfInputHeader(in), &w.x0, &w.y0, &w.x1, &w.y1);
    bool ok = w.x0 == data->x0 && w.y0 == data->y0 && w.x1 == data->x1 &&
              w.y1 == data->y1;
    if (ok)
        ok = read_strips(in, &w, (const int[2]){origin_x, origin_y}, out, err);
    else
        error_set(err, "file", "",
                  "damaged OpenEXR file: its two readers disagree about the "
                  "data window");
    ImfCloseInputFile(in);
    return ok;
}
