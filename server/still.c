// still.c - reads pixels, gathers the state as text, calls the encoder.
// Policy (which encoding when) is elsewhere.
#include "server/still.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/edit.h"
#include "renderer/encode.h"
#include "server/clock.h"
#include "server/version.h"

struct still_encoding still_encoding_of(const struct params *p)
{
    return (struct still_encoding){
        .format = p->output.format,
        .quality = p->output.quality,
        .chroma = p->output.chroma,
        .depth = p->output.depth,
    };
}

const char *still_format_name(int format)
{
    static const char *const names[] = {"jpeg", "png", "exr"};
    return names[format];
}

bool still_encoding_same(const struct still_encoding *a,
                         const struct still_encoding *b)
{
    if (a->format != b->format)
        return false;
    switch (a->format) {
    case STILL_JPEG:
        return a->quality == b->quality &&
               (a->quality == 0 || a->chroma == b->chroma);
    case STILL_EXR:
        return a->depth == b->depth;
    default:
        return true;
    }
}

// Keys and values as NUL-ended texts behind one another in `text`, pointers to
// them in `list`, which ends with NULL.
struct state_text {
    struct buf text;
    const char **list;
};

static void add(struct state_text *t, const char *key, const char *value)
{
    buf_append(&t->text, key, strlen(key) + 1);
    buf_append(&t->text, value, strlen(value) + 1);
}

static void state_text(struct state_text *t, const struct still_state *s)
{
    add(t, "glintd", VERSION_PROGRAM);
    add(t, "device", s->device);
    add(t, "hair", s->hair.name);
    add(t, "hair_sha256", s->hair.sha256);
    add(t, "env", s->env.name);
    add(t, "env_sha256", s->env.sha256);
    if (s->governor)
        add(t, "governor", s->governor);
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        buf_printf(&t->text, "%s.%s", row->group_name, row->name);
        buf_byte(&t->text, 0);
        edit_print(&t->text, s->params, row);
        buf_byte(&t->text, 0);
    }
    size_t count = 2 * ((s->governor ? 7u : 6u) + (size_t)params_row_count);
    t->list = bytes_alloc((count + 1) * sizeof *t->list);
    const char *at = (const char *)t->text.data;
    for (size_t i = 0; i < count; i++, at += strlen(at) + 1)
        t->list[i] = at;
    t->list[count] = NULL;
}

static void state_text_finish(struct state_text *t)
{
    buf_finish(&t->text);
    free(t->list);
}

// pixels: the whole, then, when they are asked for, its parts.
bool still_encode_layers(struct buf *out, const struct still_state *s,
                         const struct encode_layer *layers, int count,
                         struct error *err)
{
    struct state_text t = {0};
    state_text(&t, s);
    const struct encode_exr e = {s->params->image.width,
                                 s->params->image.height,
                                 false,
                                 layers,
                                 count,
                                 t.list};
    bool ok = encode_exr(out, &e, err);
    state_text_finish(&t);
    return ok;
}

static bool encode(struct buf *out, const struct buf *pixels,
                   const struct still_request *q, struct error *err)
{
    const struct params *p = q->state->params;
    int width = p->image.width, height = p->image.height;
    if (q->how.format == STILL_JPEG) {
        encode_jpeg(out, pixels->data, width, height, q->how.quality,
                    (enum encode_chroma)q->how.chroma);
        return true;
    }
    struct state_text t = {0};
    if (q->with_state)
        state_text(&t, q->state);
    bool ok = true;
    if (q->how.format == STILL_PNG) {
        encode_png(out, pixels->data, width, height, true, t.list);
    } else {
        struct encode_layer layer[1 + RENDERER_LAYERS];
        const int parts = q->how.layers ? RENDERER_LAYERS : 0;
        for (int i = 0; i <= parts; i++)
            layer[i] = (struct encode_layer){
                i ? renderer_layer_names[i - 1] : "",
                (const float *)(const void *)pixels[i].data, i == 0};
        struct encode_exr e = {width, height,    q->how.depth == STILL_HALF,
                               layer, 1 + parts, t.list};
        ok = encode_exr(out, &e, err);
    }
    state_text_finish(&t);
    return ok;
}

bool still_encode(struct buf *out, struct renderer *r,
                  struct still_request *request, struct error *err)
{
    struct buf pixels[1 + RENDERER_LAYERS] = {{0}};
    int64_t began = clock_us();
    bool ok = request->how.format == STILL_EXR
                  ? renderer_read_linear(r, &pixels[0], err)
                  : renderer_read_display(r, &pixels[0], err);
    for (int i = 0; ok && request->how.layers && i < RENDERER_LAYERS; i++)
        ok = renderer_read_layer(r, i, &pixels[1 + i], err);
    int64_t read = clock_us();
    if (ok)
        ok = encode(out, pixels, request, err);
    request->read_ms = (double)(read - began) / 1e3;
    request->encode_ms = (double)(clock_us() - read) / 1e3;
    for (int i = 0; i <= RENDERER_LAYERS; i++)
        buf_finish(&pixels[i]);
    return ok;
}
