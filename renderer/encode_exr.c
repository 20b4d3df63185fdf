// encode_exr.c - linear pictures through OpenEXRCore into memory.  Container
// and compression are the library's; this file hands it channels and rows.
#include "renderer/encode.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

enum {
    LAYERS_MAX = 32,
    CHANNELS_MAX = 4 * LAYERS_MAX,
    SIDE_MAX = 16384, // a row's 16 bytes a pixel stay far below 2^31
    LEVEL = 4 // of zlib; 6, the usual one, takes twice as long and saves 3 %
};

struct sink { // the file, written at any offset
    struct buf *out;
    size_t base;
};

static int64_t write_at(exr_const_context_t context, void *user,
                        const void *data, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t report)
{
    (void)context, (void)report;
    struct sink *s = user;
    size_t end = s->base + (size_t)(offset + size);
    if (end > s->out->size) {
        size_t gap = end - s->out->size;
        memset(buf_grow(s->out, gap), 0, gap);
    }
    memcpy(s->out->data + s->base + offset, data, (size_t)size);
    return (int64_t)size;
}

// Where this thread's call keeps the reason.  The library reports errors while
// it holds its lock, so that asking it for the user data would wait for ever.
static _Thread_local struct error *reason;

static void on_error(exr_const_context_t context, exr_result_t code,
                     const char *message)
{
    (void)context, (void)code;
    if (reason && !reason->text[0]) // the first one is the cause
        error_set(reason, "encode", "exr", "EXR: %s", message);
}

struct channel {
    char name[64]; // the library refuses what is longer than 31
    int layer, component;
};

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct channel *)a)->name,
                  ((const struct channel *)b)->name);
}

// In the order of their names, which is the file's order.
static int list_channels(const struct encode_exr *p, struct channel *list)
{
    static const char letter[4] = {'R', 'G', 'B', 'A'};
    int n = 0;
    for (int l = 0; l < p->layer_count; l++)
        for (int c = 0; c < (p->layers[l].alpha ? 4 : 3); c++) {
            const char *name = p->layers[l].name;
            snprintf(list[n].name, sizeof list[n].name, "%s%s%c", name,
                     *name ? "." : "", letter[c]);
            list[n].layer = l;
            list[n++].component = c;
        }
    qsort(list, (size_t)n, sizeof *list, by_name);
    return n;
}

// --- writing -----------------------------------------------------------------

struct job {
    exr_context_t file;
    const struct encode_exr *picture;
    struct channel list[CHANNELS_MAX];
    int channels;
    int chunk;                  // rows in one
    float *clamped[LAYERS_MAX]; // of a chunk; NULL for floats
    exr_result_t (*compress)(exr_encode_pipeline_t *); // the library's own
};

static bool good(exr_result_t result) // on_error has kept the reason
{
    return result == EXR_ERR_SUCCESS;
}

static bool header(struct job *j)
{
    const struct encode_exr *p = j->picture;
    exr_context_t file = j->file;
    int part = 0;
    bool ok = good(exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part)) &&
              good(exr_initialize_required_attr_simple(
                  file, part, p->width, p->height, EXR_COMPRESSION_ZIP)) &&
              good(exr_set_zip_compression_level(file, part, LEVEL));
    for (int c = 0; ok && c < j->channels; c++)
        // "logarithmic" is what every writer of linear light calls itself: the
        // eye's answer to the numbers is meant
        ok = good(exr_add_channel(file, part, j->list[c].name,
                                  p->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                                  EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    for (const char *const *t = p->text; ok && t && t[0]; t += 2)
        ok = good(exr_attr_set_string(file, part, t[0], t[1]));
    return ok && good(exr_write_header(file)) &&
           good(exr_get_scanlines_per_chunk(file, part, &j->chunk));
}

// Infinity would spread in every filter that reads the file.  NaN stays NaN.
static inline float clamp(float v)
{
    return v > 65504 ? 65504 : v < -65504 ? -65504 : v;
}

static const float *rows_of(struct job *j, int layer, int y)
{
    const struct encode_exr *p = j->picture;
    const size_t row = 4 * (size_t)p->width;
    const float *rows = p->layers[layer].rgba + row * (size_t)y;
    if (!p->half)
        return rows;
    int count = p->height - y < j->chunk ? p->height - y : j->chunk;
    float **to = &j->clamped[layer];
    if (!*to)
        *to = bytes_alloc(sizeof(float) * row * (size_t)j->chunk);
    for (size_t i = 0; i < row * (size_t)count; i++)
        (*to)[i] = clamp(rows[i]);
    return *to;
}

static void point_at(exr_encode_pipeline_t *pipe, struct job *j, int y)
{
    const float *rows[LAYERS_MAX];
    for (int l = 0; l < j->picture->layer_count; l++)
        rows[l] = rows_of(j, l, y);
    assert(pipe->channel_count == j->channels);
    for (int c = 0; c < j->channels; c++) {
        exr_coding_channel_info_t *to = &pipe->channels[c];
        const struct channel *from = &j->list[c];
        assert(strcmp(to->channel_name, from->name) == 0);
        to->user_pixel_stride = 16;
        to->user_line_stride = 16 * j->picture->width;
        to->user_bytes_per_element = 4;
        to->user_data_type = EXR_PIXEL_FLOAT; // the library makes halves of it
        to->encode_from_ptr =
            (const uint8_t *)(rows[from->layer] + from->component);
    }
}

// A chunk as long as its pixels is taken by every reader for one that was left
// uncompressed.  The library does leave it so when zlib makes it longer, but
// (until 2026) not when it comes out equal: such a chunk is read as garbage.
static exr_result_t compress(exr_encode_pipeline_t *pipe)
{
    const struct job *j = pipe->encoding_user_data;
    exr_result_t result = j->compress(pipe);
    if (good(result) && pipe->compressed_bytes == pipe->packed_bytes)
        memcpy(pipe->compressed_buffer, pipe->packed_buffer,
               pipe->packed_bytes);
    return result;
}

static bool choose(struct job *j, exr_encode_pipeline_t *pipe)
{
    if (!good(exr_encoding_choose_default_routines(j->file, 0, pipe)))
        return false;
    j->compress = pipe->compress_fn;
    pipe->compress_fn = compress;
    pipe->encoding_user_data = j;
    return true;
}

static bool chunks(struct job *j)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool ok = true;
    for (int y = 0; ok && y < j->picture->height; y += j->chunk) {
        exr_chunk_info_t info;
        ok = good(exr_write_scanline_chunk_info(j->file, 0, y, &info)) &&
             good(y == 0 ? exr_encoding_initialize(j->file, 0, &info, &pipe)
                         : exr_encoding_update(j->file, 0, &info, &pipe));
        if (!ok)
            break;
        point_at(&pipe, j, y);
        if (y == 0)
            ok = choose(j, &pipe);
        ok = ok && good(exr_encoding_run(j->file, 0, &pipe));
    }
    exr_encoding_destroy(j->file, &pipe);
    return ok;
}

static bool check(const struct encode_exr *p, struct error *err)
{
    if (p->layer_count < 1 || p->layer_count > LAYERS_MAX)
        return error_set(err, "limit", "exr",
                         "EXR: %d layers are not within [1, %d]",
                         p->layer_count, LAYERS_MAX);
    if (p->width < 1 || p->height < 1 || p->width > SIDE_MAX ||
        p->height > SIDE_MAX)
        return error_set(err, "limit", "exr",
                         "EXR: %d x %d pixels: a side is not within [1, %d]",
                         p->width, p->height, SIDE_MAX);
    return true;
}

bool encode_exr(struct buf *out, const struct encode_exr *p, struct error *err)
{
    if (!check(p, err))
        return false;
    struct error why = {0};
    struct sink sink = {out, out->size};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &sink;
    how.write_fn = write_at;
    how.error_handler_fn = on_error;
    struct job j = {.picture = p};
    j.channels = list_channels(p, j.list);
    reason = &why;
    bool ok = good(exr_start_write(&j.file, "memory", EXR_WRITE_FILE_DIRECTLY,
                                   &how)) &&
              header(&j) && chunks(&j);
    ok = good(exr_finish(&j.file)) && ok;
    reason = NULL;
    for (int l = 0; l < p->layer_count; l++)
        free(j.clamped[l]);
    if (ok)
        return true;
    out->size = sink.base;
    if (!why.text[0])
        error_set(&why, "encode", "exr", "EXR: cannot encode %d x %d pixels",
                  p->width, p->height);
    if (err)
        *err = why;
    return false;
}
