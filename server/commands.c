// commands.c - one function per verb: reads a parsed line, changes the shared
// state, replies.
#include "server/commands.h"

#include <stdio.h>
#include <string.h>

#include "protocol/edit.h"
#include "protocol/message.h"
#include "protocol/schema.h"
#include "server/args.h"
#include "server/clock.h"
#include "server/hub.h"
#include "server/stats.h"
#include "server/version.h"

// Beyond this a script that reads JSON numbers as doubles is misled.
static const struct args_range json_safe = {0, (uint64_t)1 << 53};

void commands_put_asset(struct json *j, enum loader_asset which,
                        const struct engine_asset_info *info)
{
    json_key(j, which == LOADER_HAIR ? "hair" : "env");
    json_open_object(j);
    json_put_string(j, "name", info->source.name);
    json_put_string(j, "sha256", info->source.sha256);
    if (which == LOADER_HAIR) {
        json_put_int(j, "strands", info->strands);
        json_put_int(j, "points", info->points);
    } else {
        json_put_int(j, "width", info->width);
        json_put_int(j, "height", info->height);
    }
    json_close_object(j);
}

static void answer(struct session *s, struct json *j, struct buf *out)
{
    message_end(j);
    s->out->line(s, (struct span){out->data, out->size});
    buf_finish(out);
}

// --- the verbs --------------------------------------------------------------
static bool run_ping(struct session *s, const struct line *line,
                     struct error *err)
{
    if (!args_only(line, "echo", err))
        return false;
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    json_put_int(&j, "time_us", clock_us());
    const struct line_pair *echo = line_pair(line, "echo");
    if (echo) {
        json_key(&j, "echo");
        json_span(&j, echo->value);
    }
    answer(s, &j, &out);
    return true;
}

// As long for a right token as for any wrong one of its length.
static bool token_is(struct span given, const char *token)
{
    size_t size = strlen(token);
    unsigned char differs = given.size != size;
    for (size_t i = 0; i < size && i < given.size; i++)
        differs |= (unsigned char)(given.data[i] ^ (unsigned char)token[i]);
    return differs == 0;
}

static bool run_hello(struct session *s, const struct line *line,
                      struct error *err)
{
    if (!args_only(line, "token client", err))
        return false;
    const struct line_pair *token = line_pair(line, "token");
    if (!s->allowed && !token)
        return error_set(err, "token", "token",
                         "this server wants `hello token=...` first");
    if (!s->allowed && !token_is(token->value, s->hub->token)) {
        s->quit = s->expelled = true; // one guess per connection
        return error_set(err, "token", "token", "the token is wrong");
    }
    s->allowed = true;
    struct hub *h = s->hub;
    struct engine_stats stats;
    engine_stats(h->engine, &stats);
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    json_put_string(&j, "program", "glintd " VERSION_PROGRAM);
    json_put_int(&j, "protocol", VERSION_PROTOCOL);
    json_put_int(&j, "revision", (int64_t)h->revision);
    json_put_string(&j, "device", stats.device);
    commands_put_asset(&j, LOADER_HAIR, &h->hair);
    commands_put_asset(&j, LOADER_ENV, &h->env);
    answer(s, &j, &out);
    return true;
}

static bool run_schema(struct session *s, const struct line *line,
                       struct error *err)
{
    if (!args_only(line, "", err))
        return false;
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    json_key(&j, "params");
    schema_params(&j);
    answer(s, &j, &out);
    return true;
}

static void put_value(struct json *j, const struct params *p,
                      const struct params_row *row)
{
    char name[2 * LINE_NAME_MAX];
    snprintf(name, sizeof name, "%s.%s", row->group_name, row->name);
    json_key(j, name);
    schema_value(j, p, row);
}

static bool is_group(const struct params_row *row, struct span word)
{
    return strlen(row->group_name) == word.size &&
           memcmp(row->group_name, word.data, word.size) == 0;
}

// A parameter, or all of a group.
static bool put_named(struct json *j, const struct params *p, struct span word,
                      struct error *err)
{
    bool found = false;
    for (int r = 0; r < params_row_count; r++)
        if (is_group(&params_rows[r], word)) {
            put_value(j, p, &params_rows[r]);
            found = true;
        }
    if (found)
        return true;
    const struct params_row *row = edit_find(word, err);
    if (row)
        put_value(j, p, row);
    return row != NULL;
}

// What a governor made of them.
static void put_chosen(struct json *j, const struct hub *h)
{
    if (!h->governor.note.asked[0])
        return;
    json_key(j, "chosen");
    json_open_object(j);
    for (int k = 0; k < FRONT_KNOBS; k++) {
        const char *name = front_knob_names[k];
        if (front_knob(&h->drawn, k) != front_knob(&h->params, k))
            put_value(j, &h->drawn, params_find(name, strlen(name)));
    }
    json_close_object(j);
}

static bool run_get(struct session *s, const struct line *line,
                    struct error *err)
{
    if (!args_pairs(line, "", err))
        return false;
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    bool ok = true;
    json_put_int(&j, "revision", (int64_t)s->hub->revision);
    json_key(&j, "values");
    json_open_object(&j);
    for (int i = 0; ok && i < line->word_count; i++)
        ok = put_named(&j, &s->hub->params, line->words[i], err);
    for (int r = 0; line->word_count == 0 && r < params_row_count; r++)
        put_value(&j, &s->hub->params, &params_rows[r]);
    if (!ok) {
        buf_finish(&out);
        return false;
    }
    json_close_object(&j);
    put_chosen(&j, s->hub);
    answer(s, &j, &out);
    return true;
}

// Parameters' names hold a point; seq and echo do not.
static bool edit_marks(const struct line *line, struct session_mark *m,
                       struct error *err)
{
    const struct line_pair *echo = line_pair(line, "echo");
    m->has_seq = line_pair(line, "seq") != NULL;
    if (!args_whole(line, "seq", json_safe, &m->seq, err))
        return false;
    if (!echo)
        return true;
    if (echo->value.size > SESSION_ECHO_MAX)
        return error_set(err, "limit", "echo", "echo: longer than %d bytes",
                         SESSION_ECHO_MAX);
    memcpy(m->echo, echo->value.data, echo->value.size);
    m->echo[echo->value.size] = 0;
    return true;
}

static bool run_set(struct session *s, const struct line *line,
                    struct error *err)
{
    struct line_pair pairs[LINE_PAIRS_MAX];
    int count = 0;
    struct session_mark mark = {0};
    struct params p = s->hub->params;
    if (!args_no_words(line, err) || !edit_marks(line, &mark, err))
        return false;
    for (int i = 0; i < line->pair_count; i++)
        if (!line_is(line->pairs[i].name, "seq") &&
            !line_is(line->pairs[i].name, "echo"))
            pairs[count++] = line->pairs[i];
    if (count == 0)
        return error_set(err, "syntax", "",
                         "set wants GROUP.NAME=VALUE, as in set fibre.eta=1.6");
    if (!edit_apply(&p, pairs, count, err))
        return false;
    hub_edit(s->hub, &p);
    mark.revision = s->hub->revision;
    if (mark.has_seq || mark.echo[0])
        session_remember_edit(s, &mark);
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    json_put_int(&j, "revision", (int64_t)s->hub->revision);
    answer(s, &j, &out);
    return true;
}

static bool load(struct session *s, const struct line *line,
                 enum loader_asset which, struct error *err)
{
    struct hub *h = s->hub;
    if (!args_only(line, "name", err))
        return false;
    const struct line_pair *name = line_pair(line, "name");
    if (!name) {
        struct buf out = {0};
        struct json j = message_ok(&out, line->tag);
        json_put_int(&j, "revision", (int64_t)h->revision);
        commands_put_asset(&j, which,
                           which == LOADER_HAIR ? &h->hair : &h->env);
        answer(s, &j, &out);
        return true;
    }
    char text[4096];
    if (name->value.size == 0 || name->value.size >= sizeof text)
        return error_set(err, "range", "name",
                         "name: %zu bytes are not within [1, %zu]",
                         name->value.size, sizeof text - 1);
    memcpy(text, name->value.data, name->value.size);
    text[name->value.size] = 0;
    s->job = ++h->next_job;
    session_begin_wait(s, line->tag, SESSION_LOAD);
    engine_load(h->engine, s->job, which, text);
    return true;
}

static bool run_hair(struct session *s, const struct line *line,
                     struct error *err)
{
    return load(s, line, LOADER_HAIR, err);
}

static bool run_env(struct session *s, const struct line *line,
                    struct error *err)
{
    return load(s, line, LOADER_ENV, err);
}

static bool run_capture(struct session *s, const struct line *line,
                        struct error *err)
{
    struct hub *h = s->hub;
    struct still_encoding how = still_encoding_of(&h->params);
    const struct line_pair *size = line_pair(line, "size");
    uint64_t revision = 0;
    int width = 0, height = 0;
    if (!args_only(line, "format size revision depth quality chroma layers",
                   err) ||
        !args_encoding(line, &how, err) || !args_layers(line, &how, err) ||
        !args_whole(line, "revision", json_safe, &revision, err) ||
        (size && !edit_size(size->value, "size", &width, &height, err)))
        return false;
    if (h->captures >= HUB_CAPTURES_MAX)
        return error_set(err, "limit", "capture",
                         "capture: %d captures are waiting already",
                         h->captures);
    h->captures++;
    s->capture_how = how;
    s->capture_width = width;
    s->capture_height = height;
    s->wanted_revision = revision;
    session_begin_wait(s, line->tag, SESSION_REVISION);
    session_revision(s);
    return true;
}

static bool stream_on(struct session *s, const struct line *line,
                      struct error *err)
{
    struct still_encoding how = {.quality = 0};
    uint64_t window = 2;
    if (!args_pairs(line, "window format quality chroma depth", err) ||
        !args_whole(line, "window", (struct args_range){1, SESSION_WINDOW_MAX},
                    &window, err) ||
        !args_encoding(line, &how, err))
        return false;
    if (line_pair(line, "chroma") && how.quality == 0)
        return error_set(err, "syntax", "chroma", "chroma: wants quality= too");
    if (!s->streaming && s->hub->viewers >= HUB_VIEWERS_MAX)
        return error_set(err, "limit", "stream",
                         "stream: %d clients are streaming already",
                         s->hub->viewers);
    s->hub->viewers += !s->streaming;
    s->streaming = true;
    s->window = (int)window;
    s->unacked = 0;
    s->how = how;
    s->own_format = line_pair(line, "format") != NULL;
    s->sent_serial = 0; // the newest frame comes at once, seen before or not
    return true;
}

static bool run_stream(struct session *s, const struct line *line,
                       struct error *err)
{
    bool on = line->word_count == 1 && line_is(line->words[0], "on");
    bool off = line->word_count == 1 && line_is(line->words[0], "off");
    if (!on && !off)
        return error_set(err, "syntax", "stream", "stream wants `on` or `off`");
    if (on && !stream_on(s, line, err))
        return false;
    if (off && !args_pairs(line, "", err))
        return false;
    if (off) {
        s->hub->viewers -= s->streaming;
        s->streaming = false;
    }
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    json_put_int(&j, "revision", (int64_t)s->hub->revision);
    answer(s, &j, &out);
    hub_serve(s->hub);
    return true;
}

static bool run_ack(struct session *s, const struct line *line,
                    struct error *err)
{
    uint64_t id = 0;
    if (!args_only(line, "id", err))
        return false;
    if (!line_pair(line, "id"))
        return error_set(err, "syntax", "id", "ack wants id=");
    if (!args_whole(line, "id", json_safe, &id, err) ||
        !session_ack(s, id, err))
        return false;
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    answer(s, &j, &out);
    hub_serve(s->hub);
    return true;
}

static bool run_stats(struct session *s, const struct line *line,
                      struct error *err)
{
    if (!args_only(line, "", err))
        return false;
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    stats_put(&j, s->hub);
    answer(s, &j, &out);
    return true;
}

static bool run_quit(struct session *s, const struct line *line,
                     struct error *err)
{
    if (!args_only(line, "", err))
        return false;
    struct buf out = {0};
    struct json j = message_ok(&out, line->tag);
    s->quit = true;
    answer(s, &j, &out);
    return true;
}

static const struct command {
    const char *name;
    bool (*run)(struct session *s, const struct line *line, struct error *err);
    bool open; // also before the token was given
} commands[] = {
    {"ack", run_ack, false},       {"capture", run_capture, false},
    {"env", run_env, false},       {"get", run_get, false},
    {"hair", run_hair, false},     {"hello", run_hello, true},
    {"ping", run_ping, true},      {"quit", run_quit, true},
    {"schema", run_schema, false}, {"set", run_set, false},
    {"stats", run_stats, false},   {"stream", run_stream, false},
};

bool commands_run(struct session *s, const struct line *line, struct error *err)
{
    for (size_t c = 0; c < sizeof commands / sizeof commands[0]; c++) {
        if (!line_is(line->verb, commands[c].name))
            continue;
        if (!s->allowed && !commands[c].open)
            return error_set(err, "token", "",
                             "this server wants `hello token=...` first");
        return commands[c].run(s, line, err);
    }
    return error_set(err, "unknown", "",
                     "unknown verb '%.*s'; there are ack capture env get hair "
                     "hello ping quit schema set stats stream",
                     ARGS_TEXT(line->verb));
}
