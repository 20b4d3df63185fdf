// test_json.c - the JSON writer, the replies and the schema.  What is written
// is read again by a small strict reader of RFC 8259.
#include <math.h>
#include <string.h>

#include "protocol/edit.h"
#include "protocol/json.h"
#include "protocol/message.h"
#include "protocol/number.h"
#include "protocol/schema.h"
#include "protocol/utf8.h"
#include "tests/check.h"

// --- a strict reader --------------------------------------------------------

static bool read_value(const char **at);

static bool read_string(const char **at)
{
    const char *c = *at;
    if (*c++ != '"')
        return false;
    while (*c != '"') {
        size_t n =
            utf8_next((struct span){(const unsigned char *)c, strlen(c)});
        if (n == 0 || (unsigned char)*c < 0x20)
            return false;
        if (*c == '\\') {
            c++;
            if (*c == 'u' && strspn(c + 1, "0123456789abcdefABCDEF") < 4)
                return false;
            if (!*c || !strchr("\"\\/bfnrtu", *c))
                return false;
            n = *c == 'u' ? 5 : 1;
        }
        c += n;
    }
    *at = c + 1;
    return true;
}

static bool read_number(const char **at)
{
    size_t n = strspn(*at, "+-.0123456789eE");
    double v;
    bool ok = number_parse((struct span){(const unsigned char *)*at, n}, &v);
    ok = ok && **at != '+' && !((*at)[0] == '0' && (*at)[1] == '0');
    *at += n;
    return ok;
}

static bool read_many(const char **at, char close, bool keys)
{
    (*at)++;
    if (**at == close) {
        (*at)++;
        return true;
    }
    for (;;) {
        if (keys && (!read_string(at) || *(*at)++ != ':'))
            return false;
        if (!read_value(at))
            return false;
        if (**at == close) {
            (*at)++;
            return true;
        }
        if (*(*at)++ != ',')
            return false;
    }
}

static bool read_value(const char **at)
{
    static const char *const words[] = {"true", "false", "null"};
    for (int i = 0; i < 3; i++)
        if (strncmp(*at, words[i], strlen(words[i])) == 0) {
            *at += strlen(words[i]);
            return true;
        }
    switch (**at) {
    case '{':
        return read_many(at, '}', true);
    case '[':
        return read_many(at, ']', false);
    case '"':
        return read_string(at);
    default:
        return read_number(at);
    }
}

static bool is_json(const char *s)
{
    return read_value(&s) && *s == 0;
}

// --- cases ------------------------------------------------------------------

static const char *ended(struct buf *b)
{
    buf_byte(b, 0);
    return (const char *)b->data;
}

static struct span text(const char *s)
{
    return (struct span){(const unsigned char *)s, strlen(s)};
}

static void test_writer(void)
{
    struct buf b = {0};
    struct json j = json_begin(&b);
    check_case("json: commas, nesting, every kind of value");
    json_open_object(&j);
    json_put_bool(&j, "a", true);
    json_put_int(&j, "b", INT64_MIN);
    json_key(&j, "c");
    json_open_array(&j);
    json_open_array(&j);
    json_close_array(&j);
    json_uint(&j, UINT64_MAX);
    json_null(&j);
    json_float(&j, 0.15f);
    json_number(&j, 0.15);
    json_number(&j, (double)NAN);
    json_number(&j, (double)INFINITY);
    json_float(&j, -INFINITY);
    json_string(&j, NULL);
    json_raw(&j, text("{\"x\":1}"));
    json_open_object(&j);
    json_close_object(&j);
    json_close_array(&j);
    json_put_string(&j, "d", "e");
    json_put_number(&j, "f", -0.5);
    json_close_object(&j);
    const char *got = ended(&b);
    CHECK_STR(got, "{\"a\":true,\"b\":-9223372036854775808,\"c\":[[],"
                   "18446744073709551615,null,0.15,0.15,null,null,null,null,"
                   "{\"x\":1},{}],\"d\":\"e\",\"f\":-0.5}");
    CHECK(is_json(got));
    check_case("json: the deepest nesting");
    buf_clear(&b);
    j = json_begin(&b);
    for (int i = 0; i < JSON_DEPTH_MAX; i++)
        json_open_array(&j);
    for (int i = 0; i < JSON_DEPTH_MAX; i++)
        json_close_array(&j);
    CHECK(is_json(ended(&b)));
    buf_finish(&b);
}

static void test_escapes(void)
{
    static const struct {
        const char *text, *want;
    } cases[] = {
        {"", "\"\""},
        {"a\"b\\c/", "\"a\\\"b\\\\c/\""},
        {"\n\r\t\x01\x1f\x7f", "\"\\n\\r\\t\\u0001\\u001f\\u007f\""},
        {"\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80",
         "\"\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80\""},
        {"a\x80z", "\"a\xef\xbf\xbdz\""},
        {"\xe2\x82", "\"\xef\xbf\xbd\xef\xbf\xbd\""},
        {"\xed\xa0\x80", "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\""},
    };
    check_case("json: escapes, and bytes that are not UTF-8");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct buf b = {0};
        struct json j = json_begin(&b);
        json_string(&j, cases[i].text);
        CHECK_STR(ended(&b), cases[i].want);
        CHECK(is_json((const char *)b.data));
        buf_finish(&b);
    }
    struct buf b = {0};
    struct json j = json_begin(&b);
    json_span(&j, (struct span){(const unsigned char *)"a\0b", 3});
    CHECK_STR(ended(&b), "\"a\\u0000b\"");
    buf_finish(&b);
}

static void test_replies(void)
{
    struct buf b = {0};
    struct error err;
    check_case("message: good and refusing replies, with and without a tag");
    struct json j = message_ok(&b, text("7"));
    json_put_int(&j, "revision", 12);
    message_end(&j);
    j = message_ok(&b, (struct span){NULL, 0});
    message_end(&j);
    error_set(&err, "range", "fibre.beta_r", "a \"b\"\n%d", 3);
    message_error(&b, text("x"), &err);
    message_error(&b, (struct span){NULL, 0}, &err);
    CHECK_STR(ended(&b),
              "{\"ok\":true,\"tag\":\"7\",\"revision\":12}\n"
              "{\"ok\":true}\n"
              "{\"ok\":false,\"tag\":\"x\",\"error\":{\"code\":\"range\","
              "\"name\":\"fibre.beta_r\",\"text\":\"a \\\"b\\\" 3\"}}\n"
              "{\"ok\":false,\"error\":{\"code\":\"range\",\"name\":"
              "\"fibre.beta_r\",\"text\":\"a \\\"b\\\" 3\"}}\n");
    buf_finish(&b);
}

static int count(const char *in, const char *what)
{
    int n = 0;
    for (; (in = strstr(in, what)); in += strlen(what))
        n++;
    return n;
}

static void test_schema(void)
{
    struct buf b = {0};
    struct json j = json_begin(&b);
    check_case("schema: JSON has every row, in the documented shape");
    schema_params(&j);
    const char *got = ended(&b);
    CHECK(is_json(got));
    CHECK(count(got, "{\"name\":\"") == params_row_count);
    CHECK(count(got, "\"doc\":\"") == params_row_count);
    for (int r = 0; r < params_row_count; r++) {
        char name[128];
        snprintf(name, sizeof name, "{\"name\":\"%s.%s\",",
                 params_rows[r].group_name, params_rows[r].name);
        CHECK(count(got, name) == 1);
    }
    CHECK(strstr(got, "{\"name\":\"fibre.eta\",\"group\":\"fibre\",\"title\":"
                      "\"Fibre\",\"type\":\"float\",\"unit\":\"\",\"default\":"
                      "1.55,\"min\":1.05,\"max\":3,\"choices\":[],\"auto\":"
                      "false,\"needs\":[],\"doc\":\"") != NULL);
    CHECK(strstr(got, "\"needs\":[[\"render.multiple\",\"paper\"],[\"render."
                      "multiple\",\"best\"]],\"doc\":") != NULL);
    CHECK(strstr(got, "\"type\":\"rgb\",\"unit\":\"1/radius\",\"default\":"
                      "[0.15,0.25,0.45],\"min\":0,\"max\":1000,") != NULL);
    CHECK(strstr(got, "\"type\":\"vec3\",\"unit\":\"world\",\"default\":"
                      "\"auto\",\"min\":-1000000,\"max\":1000000,\"choices\":"
                      "[],\"auto\":true,") != NULL);
    CHECK(strstr(got, "\"type\":\"bool\",\"unit\":\"\",\"default\":true,"
                      "\"min\":null,\"max\":null,") != NULL);
    CHECK(strstr(got, "\"default\":\"jpeg\",\"min\":null,\"max\":null,"
                      "\"choices\":[\"jpeg\",\"png\",\"exr\"],") != NULL);
    buf_finish(&b);
}

static void test_texts(void)
{
    struct buf b = {0};
    check_case("schema: Markdown has a line of six cells for every row");
    schema_markdown(&b);
    int rows = 0;
    char *save = NULL;
    (void)ended(&b);
    for (char *line = strtok_r((char *)b.data, "\n", &save); line;
         line = strtok_r(NULL, "\n", &save)) {
        rows += strncmp(line, "| `", 3) == 0;
        if (line[0] == '|')
            CHECK(count(line, "|") - count(line, "\\|") == 7);
    }
    CHECK(rows == params_row_count);
    check_case("schema: help fits a terminal and names everything");
    for (int r = 0; r < params_row_count; r++) {
        buf_clear(&b);
        schema_help(&b, &params_rows[r]);
        (void)ended(&b);
        CHECK(strstr((char *)b.data, params_rows[r].name) != NULL);
        CHECK(strstr((char *)b.data, params_rows[r].unit) != NULL);
        for (char *line = strtok_r((char *)b.data, "\n", &save); line;
             line = strtok_r(NULL, "\n", &save))
            if (!CHECK(strlen(line) <= 80))
                printf("  %s\n", line);
    }
    buf_clear(&b);
    schema_help_all(&b);
    (void)ended(&b);
    for (int r = 0; r < params_row_count; r++) {
        char name[128];
        snprintf(name, sizeof name, "\n%s.%s ", params_rows[r].group_name,
                 params_rows[r].name);
        CHECK(count((char *)b.data, name) == 1);
    }
    buf_finish(&b);
}

int main(void)
{
    test_writer();
    test_escapes();
    test_replies();
    test_schema();
    test_texts();
    return check_end();
}
