// stats.c - gathers what hub, engine and renderer know about themselves.
#include "server/stats.h"

#include <limits.h>
#include <sys/resource.h>

#include "server/clock.h"
#include "server/commands.h"
#include "server/frame.h"

static void put_left_out(struct json *j, const struct renderer_stats *r)
{
    json_key(j, "left_out");
    json_open_array(j);
    for (int i = 0; i < r->left_out_count; i++) {
        json_open_object(j);
        json_put_string(j, "what", r->left_out[i].what);
        json_put_string(j, "why", r->left_out[i].why);
        json_put_number(j, "bound", r->left_out[i].bound);
        json_close_object(j);
    }
    json_close_array(j);
}

static void put_memory(struct json *j, const struct engine_stats *e,
                       const struct hub *h)
{
    const struct renderer_stats *r = &e->renderer;
    int64_t held = 0;
    for (int i = 0; i < h->held_count; i++)
        held += (int64_t)h->held[i].frame.bytes->size;
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    json_key(j, "memory");
    json_open_object(j);
    json_put_int(j, "strands", (int64_t)r->memory_strands);
    json_put_int(j, "targets", (int64_t)r->memory_targets);
    json_put_int(j, "cache", (int64_t)r->memory_cache);
    json_put_int(j, "tables", (int64_t)r->memory_tables);
    json_put_int(j, "draft", (int64_t)r->memory_draft);
    json_put_int(j, "truth", (int64_t)e->verdict.memory);
    json_put_int(j, "frames", held);
    json_put_int(j, "process_peak", (int64_t)usage.ru_maxrss * 1024);
    json_close_object(j);
}

static void put_programs(struct json *j, const struct engine_stats *e)
{
    json_key(j, "programs");
    json_open_object(j);
    json_put_int(j, "kept", (int64_t)e->renderer.programs);
    json_put_int(j, "compiled", (int64_t)e->renderer.programs_compiled);
    json_put_bool(j, "warm", e->warm);
    json_put_int(j, "states", e->warm_states);
    json_key(j, "states_left");
    if (e->warm_states_left == INT_MAX)
        json_null(j);
    else
        json_int(j, e->warm_states_left);
    json_put_int(j, "left", e->warm_programs_left);
    json_close_object(j);
}

static void put_fit(struct json *j, const struct renderer_stats *r)
{
    const struct sky_fit *f = &r->fit;
    json_key(j, "fit");
    json_open_object(j);
    json_put_int(j, "lights", f->count);
    json_put_number(j, "residual", f->residual);
    json_put_number(j, "predicted_error", f->predicted_error);
    json_key(j, "energy_ratio");
    json_open_array(j);
    for (int c = 0; c < 3; c++)
        json_number(j, f->energy_ratio[c]);
    json_close_array(j);
    json_put_number(j, "seconds", f->seconds);
    json_put_int(j, "iterations", f->iterations);
    json_put_bool(j, "from_cache", f->from_cache);
    json_close_object(j);
    json_key(j, "cleaned");
    json_open_object(j);
    json_put_int(j, "negative", (int64_t)r->cleaned.negative);
    json_put_int(j, "nan", (int64_t)r->cleaned.nan);
    json_put_int(j, "infinite", (int64_t)r->cleaned.infinite);
    json_put_number(j, "energy_share", r->cleaned.energy_share);
    json_close_object(j);
}

static void put_vector(struct json *j, const char *key, const float v[3])
{
    json_key(j, key);
    json_open_array(j);
    for (int i = 0; i < 3; i++)
        json_float(j, v[i]);
    json_close_array(j);
}

void stats_put_work(struct json *j, const struct gl_counts *w)
{
    json_key(j, "work");
    json_open_object(j);
    json_put_int(j, "dispatches", (int64_t)w->dispatches);
    json_put_int(j, "draws", (int64_t)w->draws);
    json_put_int(j, "upload_bytes", (int64_t)w->upload_bytes);
    json_put_int(j, "read_bytes", (int64_t)w->read_bytes);
    json_put_int(j, "allocations", (int64_t)w->allocations);
    json_put_int(j, "programs", (int64_t)w->programs);
    json_close_object(j);
}

static void put_picture(struct json *j, const struct engine_stats *e)
{
    const struct renderer_stats *r = &e->renderer;
    static const char *const axes[] = {"x", "y", "z"};
    json_put_int(j, "samples", r->samples);
    json_put_int(j, "samples_wanted", r->samples_wanted);
    json_put_string(j, "path", r->path);
    json_put_int(j, "visible_points", r->visible_points);
    json_put_int(j, "lights_used", r->lights_used);
    json_put_int(j, "lights_fitted", r->lights_fitted);
    json_put_int(j, "tables", r->tables);
    json_put_int(j, "tables_missing", r->tables_missing);
    json_key(j, "diameter");
    json_float(j, r->diameter);
    json_put_string(j, "up", axes[r->up >= 0 && r->up < 3 ? r->up : 2]);
    put_vector(j, "eye", r->eye);
    put_vector(j, "target", r->target);
    json_key(j, "stages");
    frame_put_stages(j, r->stage_ms);
    stats_put_work(j, &r->work);
    put_left_out(j, r);
    put_fit(j, r);
}

static void put_counts(struct json *j, const struct hub *h,
                       const struct engine_stats *e)
{
    json_put_int(j, "connections", h->connections);
    json_put_int(j, "clients", h->session_count);
    json_put_int(j, "viewers", h->viewers);
    json_put_int(j, "captures_waiting", h->captures);
    json_put_int(j, "requests", (int64_t)h->requests);
    json_put_int(j, "errors", (int64_t)h->refused);
    json_put_int(j, "edits", (int64_t)h->edits);
    json_put_int(j, "coalesced", (int64_t)e->coalesced);
    json_put_int(j, "steps", (int64_t)e->steps);
    json_put_int(j, "drafts", (int64_t)e->drafts);
    json_put_int(j, "cuts", (int64_t)e->cuts);
    json_put_int(j, "frames_made", (int64_t)e->frames);
    json_put_int(j, "frames_sent", (int64_t)h->frames_sent);
    json_put_int(j, "frame_bytes_sent", (int64_t)h->bytes_sent);
    json_put_int(j, "captures", (int64_t)e->captures);
    json_put_int(j, "render_failures", (int64_t)e->failures);
}

void stats_put(struct json *j, struct hub *h)
{
    struct engine_stats e;
    engine_stats(h->engine, &e);
    json_put_int(j, "revision", (int64_t)h->revision);
    json_put_string(j, "device", e.device);
    json_put_number(j, "uptime_s",
                    (double)((clock_us() - h->started_us) / 1000) / 1e3);
    commands_put_asset(j, LOADER_HAIR, &h->hair);
    commands_put_asset(j, LOADER_ENV, &h->env);
    put_counts(j, h, &e);
    json_key(j, "progress");
    if (e.progress[0]) {
        json_open_object(j);
        json_put_string(j, "what", e.progress);
        json_put_number(j, "seconds",
                        (double)(int64_t)(e.progress_seconds * 1e3) / 1e3);
        json_close_object(j);
    } else {
        json_null(j);
    }
    put_memory(j, &e, h);
    put_programs(j, &e);
    put_picture(j, &e);
    frame_put_error(j, &e.verdict);
    json_key(j, "governor");
    governor_put(j, &h->governor);
}
