// sky_exr.c - reads OpenEXR maps.  OpenEXRCore checks the header and decodes
// what it can; sky_exr_library.c does the rest; sky_exr_colour.c brings other
// primaries to Rec. 709.
//
// Which window is the sky: with an envmap attribute the data window, as the
// OpenEXR library itself has it; otherwise the display window, so that a map
// whose black borders were cut off, or that has overscan, keeps its directions.
#include "renderer/sky_pixels.h"

#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer/sky_exr_colour.h"
#include "renderer/sky_exr_library.h"

enum { CHUNK_MAX = 512 << 20 }; // bytes of one unpacked block

struct reader {
    struct span file;
    const char *path;
    exr_context_t ctxt;
    char message[200]; // what the library said last
    struct sky_exr_window data;
    int origin[2];  // which pixel of the file is the sky's first
    int channel[3]; // index in the file for r, g, b; -1: zero
    bool library;   // luminance and chroma: only the library joins them
    struct sky_pixels *out;
    float *planes; // one chunk, planar: interleaved half to float comes out
                   // in reversed order from OpenEXRCore 3.1
    size_t plane;  // floats in one
};

static void remember(exr_const_context_t ctxt, exr_result_t code,
                     const char *message)
{
    (void)code;
    void *user = NULL;
    if (ctxt && exr_get_user_data(ctxt, &user) == EXR_ERR_SUCCESS && user) {
        struct reader *r = user;
        strncpy(r->message, message ? message : "", sizeof r->message - 1);
    }
}

static int64_t read_bytes(exr_const_context_t ctxt, void *user, void *to,
                          uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t error)
{
    (void)ctxt;
    (void)error;
    const struct reader *r = user;
    if (offset >= r->file.size)
        return 0;
    uint64_t left = r->file.size - offset;
    if (size > left)
        size = left;
    memcpy(to, r->file.data + offset, size);
    return (int64_t)size;
}

static int64_t file_size(exr_const_context_t ctxt, void *user)
{
    (void)ctxt;
    return (int64_t)((const struct reader *)user)->file.size;
}

static bool damaged(const struct reader *r, exr_result_t code,
                    const char *where, struct error *err)
{
    return error_set(err, "file", "", "damaged OpenEXR file: %s: %.160s", where,
                     r->message[0] ? r->message
                                   : exr_get_error_code_as_string(code));
}

static bool refuse(struct error *err, const char *what)
{
    return error_set(err, "file", "",
                     "the OpenEXR file is %s, which is not read; save it as a "
                     "lat-long picture in one part",
                     what);
}

static bool check_kind(struct reader *r, struct error *err)
{
    int parts = 0;
    exr_storage_t storage;
    exr_result_t rv = exr_get_count(r->ctxt, &parts);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_get_storage(r->ctxt, 0, &storage);
    if (rv != EXR_ERR_SUCCESS)
        return damaged(r, rv, "header", err);
    if (storage == EXR_STORAGE_DEEP_SCANLINE ||
        storage == EXR_STORAGE_DEEP_TILED)
        return refuse(err, "deep");
    if (parts != 1)
        return refuse(err, "multipart");
    exr_envmap_t kind;
    if (exr_attr_get_envmap(r->ctxt, 0, "envmap", &kind) == EXR_ERR_SUCCESS &&
        kind == EXR_ENVMAP_CUBE)
        return refuse(err, "a cube map");
    return true;
}

static bool check_window(const exr_attr_box2i_t *b, const char *name,
                         struct error *err)
{
    enum { FAR = 1 << 24 }; // beyond any picture; sums stay within an int
    int64_t w = (int64_t)b->max.x - b->min.x + 1;
    int64_t h = (int64_t)b->max.y - b->min.y + 1;
    if (w < 1 || h < 1 || b->min.x < -FAR || b->min.y < -FAR ||
        b->max.x > FAR || b->max.y > FAR || w > SKY_SIDE_MAX ||
        h > SKY_SIDE_MAX || w * h > SKY_PIXELS_MAX)
        return error_set(err, "limit", "",
                         "the %s window is (%d, %d) to (%d, %d); at most %.1f "
                         "megapixels and %d a side are read",
                         name, b->min.x, b->min.y, b->max.x, b->max.y,
                         1e-6 * SKY_PIXELS_MAX, SKY_SIDE_MAX);
    return true;
}

// The windows; then the output picture.
static bool open_windows(struct reader *r, struct error *err)
{
    exr_attr_box2i_t data, display;
    exr_result_t rv = exr_get_data_window(r->ctxt, 0, &data);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_get_display_window(r->ctxt, 0, &display);
    if (rv != EXR_ERR_SUCCESS)
        return damaged(r, rv, "windows", err);
    if (!check_window(&data, "data", err))
        return false;
    r->data =
        (struct sky_exr_window){data.min.x, data.min.y, data.max.x, data.max.y};
    exr_envmap_t kind;
    if (exr_attr_get_envmap(r->ctxt, 0, "envmap", &kind) == EXR_ERR_SUCCESS)
        display = data;
    else if (!check_window(&display, "display", err))
        return false;
    if (data.max.x < display.min.x || data.min.x > display.max.x ||
        data.max.y < display.min.y || data.min.y > display.max.y)
        return error_set(err, "file", "",
                         "the OpenEXR file's data window lies outside its "
                         "display window: there is no picture");
    r->origin[0] = display.min.x;
    r->origin[1] = display.min.y;
    return sky_pixels_create(r->out, (int64_t)display.max.x - display.min.x + 1,
                             (int64_t)display.max.y - display.min.y + 1, err);
}

// What there is instead of colours, for the error.
static bool no_colour(const exr_attr_chlist_t *list, struct error *err)
{
    struct buf names = {0};
    for (int i = 0; i < list->num_channels && names.size < 120; i++)
        buf_printf(&names, "%s%.40s", i ? ", " : "", list->entries[i].name.str);
    buf_byte(&names, 0);
    error_set(err, "file", "",
              "the OpenEXR file has no channel R, G, B or Y; it has %.160s",
              (const char *)names.data);
    buf_finish(&names);
    return false;
}

static bool check_channel(const exr_attr_chlist_entry_t *e, struct error *err)
{
    if (e->pixel_type != EXR_PIXEL_HALF && e->pixel_type != EXR_PIXEL_FLOAT)
        return error_set(err, "file", "",
                         "channel %.20s of the OpenEXR file holds integers; "
                         "half and float are read",
                         e->name.str);
    if (e->x_sampling != 1 || e->y_sampling != 1)
        return error_set(err, "file", "",
                         "channel %.20s of the OpenEXR file is subsampled %d x "
                         "%d, which is read for luminance and chroma only",
                         e->name.str, e->x_sampling, e->y_sampling);
    return true;
}

// R, G, B (a missing one is zero, as the library has it); else Y alone, grey;
// else Y with RY and BY.
static bool find_channels(struct reader *r, struct error *err)
{
    const exr_attr_chlist_t *list = NULL;
    exr_result_t rv = exr_get_channels(r->ctxt, 0, &list);
    if (rv != EXR_ERR_SUCCESS || !list)
        return damaged(r, rv, "channels", err);
    static const char *const names[6] = {"R", "G", "B", "Y", "RY", "BY"};
    int at[6] = {-1, -1, -1, -1, -1, -1};
    for (int i = 0; i < list->num_channels; i++)
        for (int k = 0; k < 6; k++)
            if (strcmp(list->entries[i].name.str, names[k]) == 0)
                at[k] = i;
    bool colour = at[0] >= 0 || at[1] >= 0 || at[2] >= 0;
    if (!colour && at[3] < 0)
        return no_colour(list, err);
    r->library = !colour && (at[4] >= 0 || at[5] >= 0);
    for (int k = 0; k < 3; k++) {
        r->channel[k] = colour ? at[k] : at[3];
        if (!r->library && r->channel[k] >= 0 &&
            !check_channel(&list->entries[r->channel[k]], err))
            return false;
    }
    return true;
}

// A decoded chunk, whose first pixel is (x, y) of the file, into the picture.
static void place(const struct reader *r, int x, int y, int width, int height)
{
    struct sky_pixels *out = r->out;
    x -= r->origin[0];
    y -= r->origin[1];
    for (int k = 0; k < 3; k++) {
        if (r->channel[k] < 0)
            continue;
        int same = 0; // grey: three channels read one plane
        while (r->channel[same] != r->channel[k])
            same++;
        const float *plane = r->planes + (size_t)same * r->plane;
        for (int j = 0; j < height; j++) {
            if (y + j < 0 || y + j >= out->height)
                continue;
            float *row = out->rgb + 3 * (size_t)(y + j) * (size_t)out->width;
            const float *from = plane + (size_t)j * (size_t)width;
            for (int i = 0; i < width; i++)
                if (x + i >= 0 && x + i < out->width)
                    row[3 * (x + i) + k] = from[i];
        }
    }
}

static void aim_planes(const struct reader *r, exr_decode_pipeline_t *decode,
                       int width)
{
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *ch = &decode->channels[c];
        // OpenEXRCore 3.1 crashes when one of four channels is not wanted:
        // what is not wanted goes to a fourth plane that nobody reads.
        ch->decode_to_ptr = (uint8_t *)(r->planes + 3 * r->plane);
        for (int k = 2; k >= 0; k--)
            if (r->channel[k] == c)
                ch->decode_to_ptr =
                    (uint8_t *)(r->planes + (size_t)k * r->plane);
        if (ch->data_type != EXR_PIXEL_UINT)
            ch->user_data_type = EXR_PIXEL_FLOAT;
        ch->user_bytes_per_element = 4;
        ch->user_pixel_stride = 4;
        ch->user_line_stride = 4 * width;
    }
}

// Decodes one chunk of width x height pixels into the planes.
static exr_result_t decode_chunk(struct reader *r, const exr_chunk_info_t *info,
                                 exr_decode_pipeline_t *decode, bool first,
                                 int width)
{
    exr_result_t rv = first ? exr_decoding_initialize(r->ctxt, 0, info, decode)
                            : exr_decoding_update(r->ctxt, 0, info, decode);
    if (rv != EXR_ERR_SUCCESS)
        return rv;
    aim_planes(r, decode, width);
    if (first)
        rv = exr_decoding_choose_default_routines(r->ctxt, 0, decode);
    return rv == EXR_ERR_SUCCESS ? exr_decoding_run(r->ctxt, 0, decode) : rv;
}

static bool planes_create(struct reader *r, int64_t width, int64_t height,
                          struct error *err)
{
    uint64_t unpacked = 0;
    exr_result_t rv = exr_get_chunk_unpacked_size(r->ctxt, 0, &unpacked);
    if (rv != EXR_ERR_SUCCESS)
        return damaged(r, rv, "header", err);
    if (width < 1 || height < 1 || unpacked > CHUNK_MAX ||
        width * height * 16 > CHUNK_MAX)
        return error_set(err, "limit", "",
                         "the OpenEXR file has blocks of %lld x %lld pixels, "
                         "%.0f MB; at most %d MB are read",
                         (long long)width, (long long)height,
                         1e-6 * (double)unpacked, CHUNK_MAX / 1000000);
    r->plane = (size_t)(width * height);
    r->planes = bytes_zalloc(4 * r->plane, sizeof *r->planes);
    return true;
}

static exr_result_t decode_lines(struct reader *r, int lines, int *at)
{
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t rv = EXR_ERR_SUCCESS;
    int width = r->data.x1 - r->data.x0 + 1;
    for (int y = r->data.y0; rv == EXR_ERR_SUCCESS && y <= r->data.y1;
         y += lines) {
        *at = y;
        exr_chunk_info_t info = {0};
        rv = exr_read_scanline_chunk_info(r->ctxt, 0, y, &info);
        if (rv == EXR_ERR_SUCCESS &&
            (info.start_y != y || info.width != width || info.height < 1 ||
             info.height > lines))
            rv = EXR_ERR_BAD_CHUNK_LEADER;
        if (rv == EXR_ERR_SUCCESS)
            rv = decode_chunk(r, &info, &decode, y == r->data.y0, width);
        if (rv == EXR_ERR_SUCCESS)
            place(r, r->data.x0, y, width, info.height);
    }
    exr_decoding_destroy(r->ctxt, &decode);
    return rv;
}

static exr_result_t decode_tiles(struct reader *r, int tw, int th, int *at)
{
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t rv = EXR_ERR_SUCCESS;
    int width = r->data.x1 - r->data.x0 + 1;
    int height = r->data.y1 - r->data.y0 + 1;
    for (int y = 0; rv == EXR_ERR_SUCCESS && y < height; y += th)
        for (int x = 0; rv == EXR_ERR_SUCCESS && x < width; x += tw) {
            *at = r->data.y0 + y;
            exr_chunk_info_t info = {0};
            rv = exr_read_tile_chunk_info(r->ctxt, 0, x / tw, y / th, 0, 0,
                                          &info);
            if (rv == EXR_ERR_SUCCESS && (info.width < 1 || info.width > tw ||
                                          info.height < 1 || info.height > th))
                rv = EXR_ERR_BAD_CHUNK_LEADER;
            if (rv == EXR_ERR_SUCCESS)
                rv = decode_chunk(r, &info, &decode, x == 0 && y == 0,
                                  info.width);
            if (rv == EXR_ERR_SUCCESS)
                place(r, r->data.x0 + x, r->data.y0 + y, info.width,
                      info.height);
        }
    exr_decoding_destroy(r->ctxt, &decode);
    return rv;
}

static bool read_core(struct reader *r, bool *not_implemented,
                      struct error *err)
{
    exr_storage_t storage;
    int lines = 0, tw = 0, th = 0, at = r->data.y0;
    exr_result_t rv = exr_get_storage(r->ctxt, 0, &storage);
    bool tiled = storage == EXR_STORAGE_TILED;
    if (rv == EXR_ERR_SUCCESS)
        rv = tiled ? exr_get_tile_sizes(r->ctxt, 0, 0, 0, &tw, &th)
                   : exr_get_scanlines_per_chunk(r->ctxt, 0, &lines);
    if (rv != EXR_ERR_SUCCESS)
        return damaged(r, rv, "header", err);
    if (!planes_create(r, tiled ? tw : r->data.x1 - r->data.x0 + 1,
                       tiled ? th : lines, err))
        return false;
    rv = tiled ? decode_tiles(r, tw, th, &at) : decode_lines(r, lines, &at);
    *not_implemented = rv == EXR_ERR_FEATURE_NOT_IMPLEMENTED;
    if (rv == EXR_ERR_SUCCESS)
        return true;
    char where[40];
    snprintf(where, sizeof where, "line %d", at);
    return damaged(r, rv, where, err);
}

static bool read_pixels(struct reader *r, struct error *err)
{
    if (!check_kind(r, err) || !find_channels(r, err) || !open_windows(r, err))
        return false;
    bool not_implemented = r->library;
    if (!r->library && read_core(r, &not_implemented, err))
        return true;
    return not_implemented &&
           sky_exr_library_read(r->path, &r->data, r->origin[0], r->origin[1],
                                r->out, err);
}

bool sky_exr_read(struct span file, const char *path, struct sky_pixels *out,
                  struct error *err)
{
    *out = (struct sky_pixels){0};
    struct reader r = {.file = file, .path = path, .out = out};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = remember;
    init.user_data = &r;
    init.read_fn = read_bytes;
    init.size_fn = file_size;
    init.max_image_width = init.max_image_height = SKY_SIDE_MAX;
    init.max_tile_width = init.max_tile_height = SKY_SIDE_MAX;
    // A file whose table of blocks is wrong is damaged; searching it for
    // blocks costs unbounded time.
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t rv = exr_start_read(&r.ctxt, path, &init);
    bool ok = rv == EXR_ERR_SUCCESS ? read_pixels(&r, err)
                                    : damaged(&r, rv, "header", err);
    exr_attr_chromaticities_t c;
    if (ok && exr_attr_get_chromaticities(r.ctxt, 0, "chromaticities", &c) ==
                  EXR_ERR_SUCCESS)
        sky_exr_colour_convert(
            out, (const double[4][2]){{(double)c.red_x, (double)c.red_y},
                                      {(double)c.green_x, (double)c.green_y},
                                      {(double)c.blue_x, (double)c.blue_y},
                                      {(double)c.white_x, (double)c.white_y}});
    if (rv == EXR_ERR_SUCCESS)
        exr_finish(&r.ctxt);
    free(r.planes);
    if (!ok)
        sky_pixels_finish(out);
    return ok;
}
