// http.c - takes request heads apart and decides whether they may be served.
// Sockets, time limits and what lies behind a path are the caller's.
#include "protocol/http.h"

#include <string.h>

#include "protocol/digest.h"
#include "protocol/number.h"

// --- small tests on text ----------------------------------------------------

// RFC 9110, section 5.6.2: what methods, header names and tokens are made of.
static bool is_tchar(unsigned char c)
{
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
           (c >= 'A' && c <= 'Z') || (c && strchr("!#$%&'*+-.^_`|~", c));
}

static bool is_token(struct span s)
{
    for (size_t i = 0; i < s.size; i++)
        if (!is_tchar(s.data[i]))
            return false;
    return s.size > 0;
}

static unsigned char lower(unsigned char c)
{
    return c >= 'A' && c <= 'Z' ? (unsigned char)(c + ('a' - 'A')) : c;
}

bool http_is(struct span text, const char *want)
{
    size_t n = strlen(want);
    return text.size == n && (n == 0 || memcmp(text.data, want, n) == 0);
}

bool http_is_nocase(struct span text, const char *want)
{
    if (text.size != strlen(want))
        return false;
    for (size_t i = 0; i < text.size; i++)
        if (lower(text.data[i]) != lower((unsigned char)want[i]))
            return false;
    return true;
}

static struct span trim(struct span s)
{
    while (s.size > 0 && (s.data[0] == ' ' || s.data[0] == '\t'))
        s.data++, s.size--;
    while (s.size > 0 &&
           (s.data[s.size - 1] == ' ' || s.data[s.size - 1] == '\t'))
        s.size--;
    return s;
}

// --- the head ---------------------------------------------------------------

static enum http_result bad(struct http_request *r, int status, const char *why)
{
    r->status = status;
    r->why = why;
    return HTTP_BAD;
}

// The next line of `in` from *at on, without its CRLF.
static enum http_result next_line(struct http_request *r, struct span in,
                                  size_t *at, struct span *line)
{
    const unsigned char *from = in.data + *at;
    size_t left = in.size - *at;
    const unsigned char *end = left > 0 ? memchr(from, '\n', left) : NULL;
    if (!end)
        return HTTP_MORE;
    size_t size = (size_t)(end - from);
    *at += size + 1;
    if (size == 0 || end[-1] != '\r')
        return bad(r, 400, "a line does not end with CR LF");
    *line = (struct span){from, size - 1};
    return HTTP_ONE;
}

static enum http_result version(struct http_request *r, struct span text)
{
    static const unsigned char start[] = "HTTP/";
    if (text.size != 8 || memcmp(text.data, start, 5) != 0 ||
        text.data[6] != '.' || text.data[5] < '0' || text.data[5] > '9' ||
        text.data[7] < '0' || text.data[7] > '9')
        return bad(r, 400, "the request line does not end with a version");
    if (text.data[5] != '1')
        return bad(r, 505, "only HTTP/1 is spoken here");
    r->minor = text.data[7] == '0' ? 0 : 1; // later minors count as 1.1
    return HTTP_ONE;
}

static enum http_result target(struct http_request *r, struct span text)
{
    if (text.size == 0 || text.data[0] != '/')
        return bad(r, 400, "the target is not a path");
    for (size_t i = 0; i < text.size; i++)
        if (text.data[i] <= 0x20 || text.data[i] >= 0x7f)
            return bad(r, 400, "the target holds a byte that is to be escaped");
    const unsigned char *ask = memchr(text.data, '?', text.size);
    r->target = r->path = text;
    r->query = (struct span){text.data + text.size, 0};
    if (ask) {
        r->path.size = (size_t)(ask - text.data);
        r->query = (struct span){ask + 1, text.size - r->path.size - 1};
    }
    return HTTP_ONE;
}

static enum http_result request_line(struct http_request *r, struct span line)
{
    const unsigned char *one =
        line.size > 0 ? memchr(line.data, ' ', line.size) : NULL;
    if (!one)
        return bad(r, 400, "the request line is not `METHOD target version`");
    r->method = (struct span){line.data, (size_t)(one - line.data)};
    if (!is_token(r->method))
        return bad(r, 400, "the method is not a token");
    size_t left = line.size - r->method.size - 1;
    const unsigned char *two = left > 0 ? memchr(one + 1, ' ', left) : NULL;
    if (!two)
        return bad(r, 400, "the request line is not `METHOD target version`");
    struct span middle = {one + 1, (size_t)(two - one - 1)};
    struct span last = {two + 1, left - middle.size - 1};
    enum http_result result = target(r, middle);
    return result == HTTP_ONE ? version(r, last) : result;
}

static enum http_result header_line(struct http_request *r, struct span line)
{
    const unsigned char *colon = memchr(line.data, ':', line.size);
    if (r->header_count == HTTP_HEADERS_MAX)
        return bad(r, 431, "there are more than 64 header lines");
    if (line.data[0] == ' ' || line.data[0] == '\t')
        return bad(r, 400, "a header line is folded");
    if (!colon)
        return bad(r, 400, "a header line has no colon");
    struct http_header *h = &r->headers[r->header_count++];
    h->name = (struct span){line.data, (size_t)(colon - line.data)};
    h->value = trim((struct span){colon + 1, line.size - h->name.size - 1});
    if (!is_token(h->name))
        return bad(r, 400, "a header name is not a token");
    for (size_t i = 0; i < h->value.size; i++)
        if ((h->value.data[i] < 0x20 && h->value.data[i] != '\t') ||
            h->value.data[i] == 0x7f)
            return bad(r, 400, "a header value holds a control character");
    return HTTP_ONE;
}

// What the headers together must satisfy.
static enum http_result whole(struct http_request *r)
{
    int hosts = 0, lengths = 0;
    for (int i = 0; i < r->header_count; i++) {
        struct http_header *h = &r->headers[i];
        uint64_t length;
        hosts += http_is_nocase(h->name, "host");
        if (http_is_nocase(h->name, "transfer-encoding"))
            r->has_body = true;
        if (!http_is_nocase(h->name, "content-length"))
            continue;
        if (!number_parse_u64(h->value, UINT64_MAX, &length) || ++lengths > 1)
            return bad(r, 400, "Content-Length is not one number");
        r->has_body = r->has_body || length > 0;
    }
    if (hosts > 1 || (hosts == 0 && r->minor > 0))
        return bad(r, 400, "there is not exactly one Host");
    r->keep_alive =
        !http_has_token(r, "connection", "close") &&
        (r->minor > 0 || http_has_token(r, "connection", "keep-alive"));
    return HTTP_ONE;
}

// The target of the first line, as far as it has come, is too long.  Looked at
// before anything else, because it is the one fault that shows before its line
// has ended: so the answer does not depend on how the bytes came in.
static bool target_too_long(struct span in)
{
    const unsigned char *end = memchr(in.data, '\n', in.size);
    if (end)
        in.size = (size_t)(end - in.data);
    if (in.size > 0 && in.data[in.size - 1] == '\r')
        in.size--;
    const unsigned char *from =
        in.size > 0 ? memchr(in.data, ' ', in.size) : NULL;
    if (!from)
        return false;
    from++;
    size_t left = in.size - (size_t)(from - in.data);
    const unsigned char *to = left > 0 ? memchr(from, ' ', left) : NULL;
    return (to ? (size_t)(to - from) : left) > HTTP_TARGET_MAX;
}

enum http_result http_parse(struct http_request *r, struct span in)
{
    size_t at = 0;
    struct span line;
    // What lies beyond the limit is never looked at, so that the answer does
    // not depend on how the bytes came in.
    if (in.size > HTTP_HEAD_MAX)
        in.size = HTTP_HEAD_MAX;
    r->header_count = r->status = 0;
    r->has_body = r->keep_alive = false;
    r->why = NULL;
    if (in.size == 0)
        return HTTP_MORE;
    if (target_too_long(in))
        return bad(r, 414, "the target is longer than 2048 bytes");
    for (int n = 0;; n++) {
        enum http_result result = next_line(r, in, &at, &line);
        if (result == HTTP_MORE && in.size == HTTP_HEAD_MAX)
            return bad(r, 431, "the request head is longer than 8192 bytes");
        if (result == HTTP_MORE)
            return result;
        if (result == HTTP_ONE && n > 0 && line.size == 0) {
            r->size = at;
            return whole(r);
        }
        if (result == HTTP_ONE)
            result = n == 0 ? request_line(r, line) : header_line(r, line);
        if (result == HTTP_BAD)
            return result;
    }
}

// --- questions about a request ----------------------------------------------

int http_refuse(const struct http_request *r)
{
    if (!http_is(r->method, "GET") && !http_is(r->method, "HEAD"))
        return 405;
    return r->has_body ? 413 : 0;
}

const struct span *http_header(const struct http_request *r, const char *name)
{
    for (int i = 0; i < r->header_count; i++)
        if (http_is_nocase(r->headers[i].name, name))
            return &r->headers[i].value;
    return NULL;
}

static bool list_has(struct span list, const char *token)
{
    while (list.size > 0) {
        const unsigned char *comma = memchr(list.data, ',', list.size);
        struct span part = list;
        if (comma)
            part.size = (size_t)(comma - list.data);
        if (http_is_nocase(trim(part), token))
            return true;
        size_t skip = part.size + (comma ? 1 : 0);
        list.data += skip;
        list.size -= skip;
    }
    return false;
}

bool http_has_token(const struct http_request *r, const char *name,
                    const char *token)
{
    for (int i = 0; i < r->header_count; i++)
        if (http_is_nocase(r->headers[i].name, name) &&
            list_has(r->headers[i].value, token))
            return true;
    return false;
}

static bool in_list(struct span text, const char *const *list)
{
    for (; *list; list++)
        if (http_is_nocase(text, *list))
            return true;
    return false;
}

bool http_host_allowed(const struct http_request *r, const char *const *hosts)
{
    const struct span *host = http_header(r, "host");
    return host && in_list(*host, hosts);
}

bool http_origin_allowed(const struct http_request *r,
                         const char *const *origins, bool *absent)
{
    int count = 0;
    for (int i = 0; i < r->header_count; i++)
        count += http_is_nocase(r->headers[i].name, "origin");
    const struct span *origin = http_header(r, "origin");
    *absent = count == 0;
    return count == 1 && !http_is_nocase(*origin, "null") &&
           in_list(*origin, origins);
}

int http_upgrade(const struct http_request *r, struct span *key)
{
    int keys = 0;
    if (!http_has_token(r, "upgrade", "websocket"))
        return 0;
    if (!http_is(r->method, "GET"))
        return 405;
    if (r->minor < 1 || !http_has_token(r, "connection", "upgrade"))
        return 400;
    const struct span *spoken = http_header(r, "sec-websocket-version");
    if (!spoken || !http_is(*spoken, "13"))
        return 426;
    for (int i = 0; i < r->header_count; i++)
        if (http_is_nocase(r->headers[i].name, "sec-websocket-key")) {
            *key = r->headers[i].value;
            keys++;
        }
    return keys == 1 && digest_is_base64(*key, 16) ? 101 : 400;
}
