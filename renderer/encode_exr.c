// encode_exr.c - linear pictures through OpenEXRCore into memory.  Container
// and compression are the library's; this file hands it channels and rows.
#include "renderer/encode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

enum { LAYERS_MAX = 32, CHANNELS_MAX = 4 * LAYERS_MAX };

struct sink { // the file, written at any offset
    struct buf *out;
    size_t base;
    struct error *err;
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

static void on_error(exr_const_context_t context, exr_result_t code,
                     const char *message)
{
    (void)code;
    void *user = NULL;
    if (exr_get_user_data(context, &user) != EXR_ERR_SUCCESS || !user)
        return;
    struct sink *s = user;
    error_set(s->err, "encode", "exr", "EXR: %s", message);
}

struct channel {
    char name[64];
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

static bool header(exr_context_t file, const struct encode_exr *p,
                   const struct channel *list, int channels)
{
    int part = 0;
    bool ok =
        exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part) ==
            EXR_ERR_SUCCESS &&
        exr_initialize_required_attr_simple(file, part, p->width, p->height,
                                            EXR_COMPRESSION_ZIP) ==
            EXR_ERR_SUCCESS;
    for (int c = 0; ok && c < channels; c++)
        ok = exr_add_channel(file, part, list[c].name,
                             p->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                             EXR_PERCEPTUALLY_LINEAR, 1, 1) == EXR_ERR_SUCCESS;
    for (const char *const *t = p->text; ok && t && t[0]; t += 2)
        ok = exr_attr_set_string(file, part, t[0], t[1]) == EXR_ERR_SUCCESS;
    return ok && exr_write_header(file) == EXR_ERR_SUCCESS;
}

// Rows [y, y + rows) of every layer, clamped to what a half holds: infinity
// would spread in every filter that reads the file.  NaN stays NaN.
static void clamp_rows(const struct encode_exr *p, int y, int rows,
                       float *const *scratch)
{
    const size_t n = 4 * (size_t)p->width * (size_t)rows;
    for (int l = 0; l < p->layer_count; l++) {
        const float *from = p->layers[l].rgba + 4 * (size_t)p->width * (size_t)y;
        for (size_t i = 0; i < n; i++)
            scratch[l][i] = from[i] > 65504    ? 65504
                            : from[i] < -65504 ? -65504
                                               : from[i];
    }
}

static void point_at(exr_encode_pipeline_t *pipe, const struct encode_exr *p,
                     const struct channel *list, int y, float *const *scratch)
{
    for (int c = 0; c < pipe->channel_count; c++) {
        exr_coding_channel_info_t *to = &pipe->channels[c];
        const float *rows = p->half
                                ? scratch[list[c].layer]
                                : p->layers[list[c].layer].rgba +
                                      4 * (size_t)p->width * (size_t)y;
        to->user_pixel_stride = 16;
        to->user_line_stride = 16 * p->width;
        to->user_bytes_per_element = 4;
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->encode_from_ptr = (const uint8_t *)(rows + list[c].component);
    }
}

static bool chunks(exr_context_t file, const struct encode_exr *p,
                   const struct channel *list, float *const *scratch)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t step = 1;
    bool ok = exr_get_scanlines_per_chunk(file, 0, &step) == EXR_ERR_SUCCESS;
    for (int y = 0; ok && y < p->height; y += step) {
        exr_chunk_info_t info;
        ok = exr_write_scanline_chunk_info(file, 0, y, &info) ==
             EXR_ERR_SUCCESS;
        if (!ok)
            break;
        ok = (y == 0 ? exr_encoding_initialize(file, 0, &info, &pipe)
                     : exr_encoding_update(file, 0, &info, &pipe)) ==
             EXR_ERR_SUCCESS;
        if (!ok)
            break;
        if (p->half)
            clamp_rows(p, y, p->height - y < step ? p->height - y : step,
                       scratch);
        point_at(&pipe, p, list, y, scratch);
        if (y == 0)
            ok = exr_encoding_choose_default_routines(file, 0, &pipe) ==
                 EXR_ERR_SUCCESS;
        ok = ok && exr_encoding_run(file, 0, &pipe) == EXR_ERR_SUCCESS;
    }
    exr_encoding_destroy(file, &pipe);
    return ok;
}

bool encode_exr(struct buf *out, const struct encode_exr *p, struct error *err)
{
    if (p->layer_count < 1 || p->layer_count > LAYERS_MAX)
        return error_set(err, "limit", "exr",
                         "EXR: %d layers are not within [1, %d]",
                         p->layer_count, LAYERS_MAX);
    struct channel list[CHANNELS_MAX];
    float *scratch[LAYERS_MAX] = {0};
    const size_t before = out->size;
    int channels = list_channels(p, list);
    // a ZIP chunk is 16 rows
    for (int l = 0; p->half && l < p->layer_count; l++)
        scratch[l] = bytes_alloc(16 * 16 * (size_t)p->width);
    struct error why = {0};
    struct sink sink = {out, before, &why};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &sink;
    how.write_fn = write_at;
    how.error_handler_fn = on_error;
    exr_context_t file = NULL;
    bool ok = exr_start_write(&file, "memory", EXR_WRITE_FILE_DIRECTLY,
                              &how) == EXR_ERR_SUCCESS &&
              header(file, p, list, channels) &&
              chunks(file, p, list, scratch);
    ok = exr_finish(&file) == EXR_ERR_SUCCESS && ok;
    for (int l = 0; l < p->layer_count; l++)
        free(scratch[l]);
    if (ok)
        return true;
    out->size = before;
    if (!why.text[0])
        error_set(&why, "encode", "exr", "EXR: cannot encode %d x %d pixels",
                  p->width, p->height);
    if (err)
        *err = why;
    return false;
}
