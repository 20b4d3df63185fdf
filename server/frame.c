// frame.c - writes frame headers; sends nothing.
#include "server/frame.h"

#include <math.h>

void frame_put_ms(struct json *j, const char *key, double ms)
{
    json_put_number(j, key, round(ms * 1e3) / 1e3);
}

void frame_put_stages(struct json *j, const double ms[RENDERER_STAGES])
{
    json_open_object(j);
    for (int i = 0; i < RENDERER_STAGES; i++)
        if (ms[i] >= 0)
            frame_put_ms(j, renderer_stage_names[i], ms[i]);
    json_close_object(j);
}

void frame_put_error(struct json *j, const struct judge_verdict *v)
{
    json_key(j, "error");
    if (v->revision == 0) {
        json_null(j);
        return;
    }
    json_open_object(j);
    json_put_string(j, "reference", "path");
    json_put_string(j, "metric", "rel_rmse");
    json_put_number(j, "value", v->value);
    json_put_number(j, "ci95", fmax(v->high - v->value, v->value - v->low));
    json_put_number(j, "mean_signed", v->bias);
    json_put_number(j, "noise", v->noise);
    json_put_int(j, "places", v->places);
    json_put_int(j, "paths", v->paths);
    json_put_number(j, "seconds", v->seconds);
    json_put_int(j, "revision", (int64_t)v->revision);
    json_close_object(j);
}

static void put_format(struct json *j, const struct still_encoding *e)
{
    json_put_string(j, "format", still_format_name(e->format));
    if (e->format == STILL_JPEG) {
        json_put_int(j, "quality", e->quality);
        json_put_string(j, "chroma", e->chroma ? "444" : "420");
    } else if (e->format == STILL_EXR) {
        json_put_string(j, "depth", e->depth ? "float" : "half");
        if (e->layers)
            json_put_bool(j, "layers", true);
    }
}

// What a draft leaves out.
static void put_draft(struct json *j, const struct renderer_draft *d)
{
    if (d->divisor == 0)
        return;
    json_key(j, "draft");
    json_open_object(j);
    json_put_int(j, "divisor", d->divisor);
    json_put_int(j, "stride", d->stride);
    json_put_bool(j, "coarse_shadows", d->coarse);
    if (d->fitted)
        json_put_bool(j, "earlier_fit", true);
    json_close_object(j);
}

void frame_put(struct json *j, const struct studio_frame *f,
               const struct frame_about *about)
{
    json_key(j, "frame");
    json_open_object(j);
    json_put_int(j, "id", (int64_t)about->id);
    json_put_int(j, "revision", (int64_t)f->revision);
    if (about->shown && about->shown->has_seq)
        json_put_int(j, "seq", (int64_t)about->shown->seq);
    if (about->shown && about->shown->echo[0])
        json_put_string(j, "echo", about->shown->echo);
    put_format(j, &f->used);
    json_put_int(j, "width", f->width);
    json_put_int(j, "height", f->height);
    json_put_int(j, "x", 0);
    json_put_int(j, "y", 0);
    json_put_int(j, "bytes", (int64_t)f->bytes->size);
    json_put_string(j, "level",
                    f->draft.divisor > 0 ? "draft"
                    : f->final           ? "final"
                                         : "full");
    json_put_bool(j, "final", f->final);
    json_put_int(j, "samples", f->samples);
    put_draft(j, &f->draft);
    json_put_string(j, "path", f->path);
    frame_put_ms(j, "render_ms", f->render_ms);
    frame_put_ms(j, "encode_ms", f->encode_ms);
    json_put_int(j, "received_us", f->received_us);
    json_put_int(j, "queued_us", about->queued_us);
    json_key(j, "stages");
    frame_put_stages(j, f->stage_ms);
    if (f->note.asked[0]) {
        json_key(j, "governor");
        governor_put_line(j, &f->note);
    }
    if (f->verdict.revision > 0)
        frame_put_error(j, &f->verdict);
    json_close_object(j);
}
