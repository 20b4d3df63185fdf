// test_protocol.c - lines, edits, numbers and JSON under damaged input.  The
// laws need no second parser: the outcome does not depend on how a stream was
// cut, spans lie inside what was given, refused edits change nothing, printed
// values read back.
#include <math.h>

#include "protocol/edit.h"
#include "protocol/json.h"
#include "protocol/line.h"
#include "protocol/number.h"
#include "protocol/utf8.h"
#include "tests/fuzz/mutate.h"
// The client is not among the objects that tests are linked with.
#include "protocol/client/find.c"

// --- lines and edits --------------------------------------------------------

static const char *const line_texts[] = {
    "ping",
    "#7 get fibre.eta light.yaw",
    "#a-B_1.2:3 stream on window=2 format=jpeg",
    "set fibre.sigma_a=0.2,0.3,0.5 light.yaw=30 seq=5 echo=\"a b\"",
    "set camera.eye=1e2,-3,auto output.format=exr view.head=off",
    "hair name=\"\\u00e9\\n\\\\\\\"\\ud83d\\ude00\"",
    "capture format=exr size=720x480 revision=12",
    "set image.width=8192 image.height=8192",
};
static const char *const line_words[] = {" ",
                                         "=",
                                         "\"",
                                         "#",
                                         "\\",
                                         "\\u",
                                         "\\u0000",
                                         "\\ud83d",
                                         "\\ude00",
                                         "\n",
                                         "\xe2\x82\xac",
                                         "\x80",
                                         "auto",
                                         "nan",
                                         "1e308",
                                         "-0",
                                         "1e-40",
                                         ",",
                                         "0x1",
                                         "fibre.eta=",
                                         "image.width=1 ",
                                         "output.format=jpeg ",
                                         "a=1 ",
                                         "\r\n",
                                         "GET ",
                                         "Host:",
                                         "camera.up=0,0,1 ",
                                         "hair.scale=3 ",
                                         "tint.colour=2 "};

static bool law_line(void)
{
    static struct line line;
    struct error err = {0};
    struct span text = given();
    if (!line_parse(&line, text, &err)) {
        LAW(strcmp(err.code, "syntax") == 0 || strcmp(err.code, "limit") == 0);
        LAW(err.text[0] != 0);
        LAW(within(line.tag, text));
        return true;
    }
    struct span store = {line.store.data, line.store.size};
    LAW(utf8_valid(text) && within(line.verb, text) && line.verb.size > 0);
    for (int i = 0; i < line.word_count; i++)
        LAW(within(line.words[i], text) && line.words[i].size > 0);
    for (int i = 0; i < line.pair_count; i++) {
        struct line_pair *p = &line.pairs[i];
        LAW(within(p->name, text) && utf8_valid(p->value));
        LAW(within(p->value, p->quoted ? store : text));
        for (int k = 0; k < i; k++)
            LAW(p->name.size != line.pairs[k].name.size ||
                memcmp(p->name.data, line.pairs[k].name.data, p->name.size));
    }
    return true;
}

// Every value lies within its row's range, and reads back from its own text.
static bool legal_values(const struct params *p)
{
    struct params again;
    struct error err = {0};
    params_defaults(&again);
    again.image.width = again.image.height = 1; // both together are limited
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        struct buf text = {0};
        buf_printf(&text, "%s.%s=", row->group_name, row->name);
        edit_print(&text, p, row);
        buf_byte(&text, 0);
        bool ok = edit_apply_text(&again, (char *)text.data, &err);
        buf_finish(&text);
        LAW(ok);
        for (int i = 0; i < row->count; i++) {
            double v = params_get(p, row, i);
            if (row->type == PARAMS_CHOICE)
                LAW(edit_choice(row, (int)v).size > 0);
            else
                LAW((isnan(v) && row->has_auto) ||
                    (v >= (double)(float)row->min &&
                     v <= (double)(float)row->max));
        }
    }
    LAW(params_changed(p, &again) == 0);
    LAW((int64_t)p->image.width * p->image.height <= EDIT_PIXELS_MAX);
    return true;
}

static bool law_edit(void)
{
    static struct line line;
    static struct params p;
    struct error err = {0};
    struct line_pair pairs[LINE_PAIRS_MAX];
    int count = 0;
    if (p.image.width == 0)
        params_defaults(&p);
    if (!line_parse(&line, given(), &err))
        return true;
    for (int i = 0; i < line.pair_count; i++)
        if (memchr(line.pairs[i].name.data, '.', line.pairs[i].name.size))
            pairs[count++] = line.pairs[i];
    struct params before = p;
    if (edit_apply(&p, pairs, count, &err))
        return count == 0 || params_changed(&p, &before) == 0 ||
               legal_values(&p);
    LAW(memcmp(&p, &before, sizeof p) == 0);
    LAW(err.code[0] && err.text[0]);
    return true;
}

// What a stream of lines is, cut into pieces of `step` bytes (0: whole).
static void lines_of(struct buf *out, size_t step)
{
    size_t have = step && step < input_size ? step : input_size;
    size_t from = 0, scanned = 0;
    buf_clear(out);
    for (;;) {
        struct span line;
        struct error err;
        size_t used = 0;
        struct span in = {input + from, have - from};
        enum line_result r = line_cut(in, &scanned, &line, &used, &err);
        if (r == LINE_BAD) {
            buf_printf(out, "!%s", err.code);
            return;
        }
        if (r == LINE_ONE) {
            buf_append(out, line.data, line.size);
            buf_byte(out, '\n');
            from += used;
        } else if (have == input_size) {
            return;
        } else {
            have = input_size - have < step ? input_size : have + step;
        }
    }
}

static bool law_stream(void)
{
    static struct buf whole, pieces;
    lines_of(&whole, 0);
    for (size_t step = 1; step < 6; step++) {
        lines_of(&pieces, step);
        LAW(same(&whole, &pieces));
    }
    return true;
}

static const char *const stream_texts[] = {
    "ping\n#7 get a\r\nset a=1\n\n",
    "ping\nGET / HTTP/1.1\r\nHost: x\r\n\r\n",
    "\r\n\r\nhost: x\nping\n",
};

// --- numbers ----------------------------------------------------------------

static const char *const number_texts[] = {
    "0",        "-1.5",
    "1e3",      "123456789.987654321e-10",
    "4.9e-324", "1.7976931348623157e308",
    "0.1",      "+7",
    "inf",      "nan",
    "0x1p3",    "1e999"};
static const char *const number_words[] = {
    "0", "9", "e", ".", "-", "+", "1e", "99999999", "e-3", "00", ",", " "};

static bool law_number(void)
{
    double got = 0, back = 0;
    char copy[NUMBER_TEXT_MAX + 1], out[NUMBER_BUFFER], *end;
    if (!number_parse(given(), &got))
        return true;
    LAW(input_size <= NUMBER_TEXT_MAX);
    memcpy(copy, input, input_size);
    copy[input_size] = 0;
    LAW(strtod(copy, &end) == got && *end == 0 && isfinite(got));
    LAW(strspn(copy, "0123456789.eE+-") == input_size);
    size_t n = number_print(out, got);
    LAW(number_parse((struct span){(unsigned char *)out, n}, &back));
    LAW(back == got && signbit(back) == signbit(got));
    return true;
}

// --- JSON -------------------------------------------------------------------

static const char *const json_texts[] = {
    "{\"ok\":true,\"tag\":\"7\",\"frame\":{\"id\":5,\"bytes\":99,\"stages\":"
    "{\"shade\":1.5},\"list\":[1,[2],{}]}}",
    "{\"ok\":false,\"error\":{\"code\":\"range\",\"text\":\"a \\\"b\\\" \\u20ac"
    "\\ud83d\\ude00\"}}",
    "[1,2,3]", "\"text\\n\"", "{}"};
static const char *const json_words[] = {
    "{",          "}",       "[",    "]",       "\"",   ",",
    ":",          "\\",      "\\u",  "\\ud83d", "null", "1e9",
    "\"frame\":", "{\"a\":", "[[[[", "}}}}",    "\x80"};

static bool law_find(void)
{
    static struct buf text;
    struct span all = given(), key, value, inner;
    size_t at = 0, steps = 0;
    uint64_t number;
    while (find_member(all, &at, &key, &value)) {
        LAW(within(key, all) && within(value, all) && ++steps <= input_size);
        buf_clear(&text);
        if (find_text(value, &text))
            for (size_t i = 0; i < text.size; i++)
                LAW(text.data[i] >= 0x20 && text.data[i] != 0x7f);
    }
    for (at = 0, steps = 0; find_item(all, &at, &value);)
        LAW(within(value, all) && ++steps <= input_size);
    if (find_key(all, "frame", &value))
        LAW(within(value, all) &&
            (!find_key(value, "stages", &inner) || within(inner, value)));
    (void)find_u64(all, "id", &number);
    (void)find_text(all, &text);
    return true;
}

// What json_span writes, find_text reads: where the text is valid and holds no
// control characters they are the same.
static bool law_json(void)
{
    static struct buf out, back;
    buf_clear(&out);
    buf_clear(&back);
    struct json j = json_begin(&out);
    json_span(&j, given());
    LAW(utf8_valid((struct span){out.data, out.size}));
    LAW(find_text((struct span){out.data, out.size}, &back));
    bool plain = utf8_valid(given());
    for (size_t i = 0; i < input_size; i++)
        plain = plain && input[i] >= 0x20 && input[i] != 0x7f;
    LAW(!plain ||
        (back.size == input_size &&
         (input_size == 0 || memcmp(back.data, input, input_size) == 0)));
    return true;
}

int main(void)
{
    const struct corpus lines = CORPUS(line_texts, line_words);
    const struct corpus streams = CORPUS(stream_texts, line_words);
    const struct corpus numbers = CORPUS(number_texts, number_words);
    const struct corpus json = CORPUS(json_texts, json_words);
    catch_crashes();
    run("fuzz: request lines", &lines, 300000, law_line);
    run("fuzz: edits", &lines, 60000, law_edit);
    run("fuzz: streams of lines, cut anywhere", &streams, 150000, law_stream);
    run("fuzz: numbers", &numbers, 150000, law_number);
    run("fuzz: looking values up in JSON", &json, 200000, law_find);
    run("fuzz: JSON texts written and read", &json, 100000, law_json);
    free(input);
    return check_end();
}
