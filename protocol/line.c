// line.c - cuts lines out of a stream and takes one line apart.  What a verb
// or a name means is left to others.
#include "protocol/line.h"

#include <string.h>

#include "protocol/utf8.h"

#define METHOD_MAX 32 // longest upper-case word that is taken for HTTP's

// --- a stream of lines ------------------------------------------------------

enum line_result line_looks_http(struct span first)
{
    size_t n = 0;
    while (n < first.size && n <= METHOD_MAX && first.data[n] >= 'A' &&
           first.data[n] <= 'Z')
        n++;
    if (n > METHOD_MAX)
        return LINE_BAD;
    if (n == first.size)
        return LINE_MORE;
    return n > 0 && first.data[n] == ' ' ? LINE_ONE : LINE_BAD;
}

// "Host:" in any case begins a line that only HTTP has.
static bool looks_host(struct span first)
{
    static const char host[] = "host:";
    if (first.size < sizeof host - 1)
        return false;
    for (size_t i = 0; i < sizeof host - 1; i++) {
        unsigned char c = first.data[i];
        if (c >= 'A' && c <= 'Z')
            c = (unsigned char)(c + ('a' - 'A'));
        if (c != (unsigned char)host[i])
            return false;
    }
    return true;
}

static enum line_result bad(struct error *err, const char *code,
                            const char *text)
{
    error_set(err, code, "", "%s", text);
    return LINE_BAD;
}

enum line_result line_cut(struct span in, size_t *scanned, struct span *line,
                          size_t *used, struct error *err)
{
    if (line_looks_http(in) == LINE_ONE || looks_host(in))
        return bad(err, "http",
                   "a line that begins as HTTP does ends the connection");
    const unsigned char *end = NULL;
    if (*scanned < in.size)
        end = memchr(in.data + *scanned, '\n', in.size - *scanned);
    size_t size = end ? (size_t)(end - in.data) : in.size;
    if (size > LINE_BYTES_MAX)
        return bad(err, "limit", "the line is longer than 65536 bytes");
    if (!end) {
        *scanned = in.size;
        return LINE_MORE;
    }
    *scanned = 0;
    *used = size + 1;
    if (size > 0 && in.data[size - 1] == '\r')
        size--;
    *line = (struct span){in.data, size};
    return LINE_ONE;
}

// --- one line ---------------------------------------------------------------

struct reader {
    struct span in;
    size_t at;
    struct error *err;
};

static bool lower_start(struct span s)
{
    return s.size > 0 && s.data[0] >= 'a' && s.data[0] <= 'z';
}

static bool is_name(struct span s)
{
    if (!lower_start(s))
        return false;
    for (size_t i = 1; i < s.size; i++) {
        unsigned char c = s.data[i];
        if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
              c == '.'))
            return false;
    }
    return true;
}

static bool is_tag(struct span s)
{
    for (size_t i = 0; i < s.size; i++) {
        unsigned char c = s.data[i];
        if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
              (c >= '0' && c <= '9') || (c && strchr("_.:-", c))))
            return false;
    }
    return s.size > 0;
}

// Refuses, quoting the span as far as a person needs it.
static bool refuse(struct error *err, const char *code, struct span s,
                   const char *why)
{
    int shown = (int)utf8_cut(s, 40);
    return error_set(err, code, "", "\"%.*s%s\" %s", shown,
                     (const char *)s.data, (size_t)shown < s.size ? "..." : "",
                     why);
}

static bool check_bytes(struct span text, struct error *err)
{
    for (size_t i = 0; i < text.size; i++)
        if (text.data[i] < 0x20 || text.data[i] == 0x7f)
            return error_set(err, "syntax", "",
                             "byte %zu of the line is the control character "
                             "0x%02x; write it as an escape in quotes",
                             i + 1, text.data[i]);
    for (size_t i = 0; i < text.size;) {
        struct span rest = {text.data + i, text.size - i};
        size_t n = utf8_next(rest);
        if (n == 0)
            return error_set(err, "syntax", "",
                             "byte %zu of the line is not UTF-8", i + 1);
        i += n;
    }
    return true;
}

// Everything up to the next blank, or to the end.
static struct span token(struct reader *r)
{
    size_t from = r->at;
    while (r->at < r->in.size && r->in.data[r->at] != ' ')
        r->at++;
    return (struct span){r->in.data + from, r->at - from};
}

static bool hex4(struct reader *r, uint32_t *out)
{
    *out = 0;
    if (r->in.size - r->at < 4)
        return false;
    for (int i = 0; i < 4; i++) {
        unsigned char c = r->in.data[r->at++];
        if (c >= '0' && c <= '9')
            c = (unsigned char)(c - '0');
        else if (c >= 'a' && c <= 'f')
            c = (unsigned char)(c - 'a' + 10);
        else if (c >= 'A' && c <= 'F')
            c = (unsigned char)(c - 'A' + 10);
        else
            return false;
        *out = *out << 4 | c;
    }
    return true;
}

// After "\u": one character, which may take a second "\uXXXX".
static bool unicode(struct reader *r, uint32_t *out)
{
    uint32_t low;
    if (!hex4(r, out))
        return error_set(r->err, "syntax", "",
                         "\\u is not followed by four hexadecimal digits");
    if (*out >= 0xd800 && *out < 0xdc00) {
        bool pair = r->in.size - r->at >= 2 && r->in.data[r->at] == '\\' &&
                    r->in.data[r->at + 1] == 'u';
        r->at += pair ? 2 : 0;
        if (!pair || !hex4(r, &low) || low < 0xdc00 || low > 0xdfff)
            return error_set(r->err, "syntax", "",
                             "\\u%04x is half of a surrogate pair", *out);
        *out = 0x10000 + ((*out - 0xd800) << 10) + (low - 0xdc00);
    } else if (*out >= 0xdc00 && *out <= 0xdfff) {
        return error_set(r->err, "syntax", "",
                         "\\u%04x is half of a surrogate pair", *out);
    }
    if (*out == 0)
        return error_set(r->err, "syntax", "", "\\u0000 is not allowed");
    return true;
}

static bool escape(struct reader *r, struct buf *store)
{
    unsigned char utf8[4];
    uint32_t c = 0;
    if (r->at == r->in.size)
        return error_set(r->err, "syntax", "", "a quoted value has no end");
    switch (r->in.data[r->at++]) {
    case '\\':
        c = '\\';
        break;
    case '"':
        c = '"';
        break;
    case 'n':
        c = '\n';
        break;
    case 'u':
        if (!unicode(r, &c))
            return false;
        break;
    default:
        return error_set(r->err, "syntax", "",
                         "unknown escape in a quoted value; there are \\\\, "
                         "\\\", \\n and \\uXXXX");
    }
    buf_append(store, utf8, utf8_put(utf8, c));
    return true;
}

// After the opening quote.  What was unquoted goes to `store`, which is large
// enough for the whole line, because unquoting never adds bytes: it does not
// move while spans point into it.
static bool quoted(struct reader *r, struct buf *store, struct span *out)
{
    size_t from = store->size;
    for (;;) {
        if (r->at == r->in.size)
            return error_set(r->err, "syntax", "", "a quoted value has no end");
        unsigned char c = r->in.data[r->at++];
        if (c == '"')
            break;
        if (c != '\\')
            buf_byte(store, c);
        else if (!escape(r, store))
            return false;
    }
    if (r->at < r->in.size && r->in.data[r->at] != ' ')
        return error_set(r->err, "syntax", "",
                         "a quoted value is followed by something other than "
                         "a blank");
    *out = (struct span){store->data + from, store->size - from};
    return true;
}

static bool value(struct reader *r, struct line *line, struct line_pair *pair)
{
    if (r->at < r->in.size && r->in.data[r->at] == '"') {
        r->at++;
        pair->quoted = true;
        if (line->store.size == 0)
            buf_reserve(&line->store, r->in.size);
        return quoted(r, &line->store, &pair->value);
    }
    pair->value = token(r);
    if (pair->value.size == 0)
        return refuse(r->err, "syntax", pair->name,
                      "is given no value; an empty text is written \"\"");
    if (memchr(pair->value.data, '"', pair->value.size))
        return refuse(r->err, "syntax", pair->value,
                      "has a quote inside an unquoted value");
    return true;
}

static bool same(struct span a, struct span b)
{
    return a.size == b.size && memcmp(a.data, b.data, a.size) == 0;
}

static bool pair(struct reader *r, struct line *line, struct span name)
{
    if (!is_name(name))
        return refuse(r->err, "syntax", name,
                      "is not a name of the form [a-z][a-z0-9_.]*");
    if (name.size > LINE_NAME_MAX)
        return refuse(r->err, "limit", name, "is longer than 64 bytes");
    for (int i = 0; i < line->pair_count; i++)
        if (same(line->pairs[i].name, name))
            return refuse(r->err, "syntax", name, "is given twice");
    if (line->pair_count == LINE_PAIRS_MAX)
        return error_set(r->err, "limit", "",
                         "the line has more than %d name=value pairs",
                         LINE_PAIRS_MAX);
    struct line_pair *p = &line->pairs[line->pair_count];
    *p = (struct line_pair){.name = name};
    r->at++; // the "="
    if (!value(r, line, p))
        return false;
    line->pair_count++;
    return true;
}

static bool word(struct reader *r, struct line *line, struct span text)
{
    if (text.size == 0)
        return error_set(r->err, "syntax", "",
                         "one blank separates, and none ends a line");
    if (memchr(text.data, '"', text.size))
        return refuse(r->err, "syntax", text, "has a quote inside a word");
    if (line->pair_count > 0)
        return refuse(r->err, "syntax", text,
                      "stands after a name=value pair; words come first");
    if (line->word_count == LINE_WORDS_MAX)
        return error_set(r->err, "limit", "", "the line has more than %d words",
                         LINE_WORDS_MAX);
    line->words[line->word_count++] = text;
    return true;
}

// One token after the verb.
static bool item(struct reader *r, struct line *line)
{
    size_t from = r->at;
    size_t end = from;
    while (end < r->in.size && !strchr(" =\"", r->in.data[end]))
        end++;
    if (end < r->in.size && r->in.data[end] == '=') {
        r->at = end;
        return pair(r, line, (struct span){r->in.data + from, end - from});
    }
    return word(r, line, token(r));
}

static bool head(struct reader *r, struct line *line)
{
    struct span first = token(r);
    if (first.size > 0 && first.data[0] == '#') {
        struct span tag = {first.data + 1, first.size - 1};
        if (!is_tag(tag))
            return refuse(r->err, "syntax", first,
                          "is not a tag of the form #[A-Za-z0-9_.:-]+");
        if (tag.size > LINE_TAG_MAX)
            return refuse(r->err, "limit", first,
                          "is a tag longer than 64 bytes");
        line->tag = tag;
        if (r->at < r->in.size)
            r->at++;
        first = token(r);
    }
    if (first.size == 0)
        return error_set(r->err, "syntax", "",
                         "the line has no verb at its place");
    if (!is_name(first))
        return refuse(r->err, "syntax", first,
                      "is not a verb of the form [a-z][a-z0-9_.]*");
    if (first.size > LINE_NAME_MAX)
        return refuse(r->err, "limit", first, "is a verb longer than 64 bytes");
    line->verb = first;
    return true;
}

bool line_parse(struct line *line, struct span text, struct error *err)
{
    struct error later;
    if (text.size == 0) // no arithmetic on a NULL
        text.data = (const unsigned char *)"";
    struct reader r = {text, 0, err};
    line->tag = line->verb = (struct span){text.data, 0};
    line->word_count = line->pair_count = 0;
    buf_clear(&line->store);
    if (text.size > LINE_BYTES_MAX)
        return error_set(err, "limit", "", "the line is longer than %d bytes",
                         LINE_BYTES_MAX);
    if (!check_bytes(text, err)) {
        // The reply to a line with bad bytes still carries its tag.
        r.err = &later;
        (void)head(&r, line);
        return false;
    }
    if (!head(&r, line))
        return false;
    while (r.at < text.size) {
        r.at++; // the blank
        if (!item(&r, line))
            return false;
    }
    return true;
}

void line_finish(struct line *line)
{
    buf_finish(&line->store);
}

bool line_is(struct span text, const char *want)
{
    size_t n = strlen(want);
    return text.size == n && memcmp(text.data, want, n) == 0;
}

const struct line_pair *line_pair(const struct line *line, const char *name)
{
    for (int i = 0; i < line->pair_count; i++)
        if (line_is(line->pairs[i].name, name))
            return &line->pairs[i];
    return NULL;
}
