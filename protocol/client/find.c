// find.c - a forward scan over JSON.  Everything that is not asked for is
// skipped by counting brackets outside of strings.
#include "protocol/client/find.h"

#include <string.h>

#include "protocol/number.h"
#include "protocol/utf8.h"

// The place after the string that begins at `at`.
static size_t after_string(struct span s, size_t at)
{
    for (at++; at < s.size; at++) {
        if (s.data[at] == '\\')
            at++;
        else if (s.data[at] == '"')
            return at + 1;
    }
    return s.size;
}

static size_t after_value(struct span s, size_t at)
{
    size_t depth = 0;
    while (at < s.size) {
        unsigned char c = s.data[at];
        if (c == '"') {
            at = after_string(s, at);
            if (depth == 0)
                return at;
            continue;
        }
        if (c == '{' || c == '[') {
            depth++;
        } else if (c == '}' || c == ']') {
            if (depth == 0)
                return at;
            if (--depth == 0)
                return at + 1;
        } else if (c == ',' && depth == 0) {
            return at;
        }
        at++;
    }
    return at;
}

// Steps over the opening bracket or the comma before an item.
static bool next(struct span s, size_t *at, char open)
{
    if (*at >= s.size || s.data[*at] != (*at == 0 ? open : ','))
        return false;
    ++*at;
    return *at < s.size && s.data[*at] != '}' && s.data[*at] != ']';
}

bool find_item(struct span array, size_t *at, struct span *value)
{
    if (!next(array, at, '['))
        return false;
    size_t end = after_value(array, *at);
    *value = (struct span){array.data + *at, end - *at};
    *at = end;
    return true;
}

bool find_member(struct span object, size_t *at, struct span *key,
                 struct span *value)
{
    if (!next(object, at, '{') || object.data[*at] != '"')
        return false;
    size_t end = after_string(object, *at);
    if (end >= object.size || object.data[end] != ':' || end - *at < 2)
        return false;
    *key = (struct span){object.data + *at + 1, end - *at - 2};
    *at = after_value(object, end + 1);
    *value = (struct span){object.data + end + 1, *at - end - 1};
    return true;
}

bool find_key(struct span object, const char *key, struct span *value)
{
    struct span name;
    size_t at = 0, size = strlen(key);
    while (find_member(object, &at, &name, value))
        if (name.size == size && memcmp(name.data, key, size) == 0)
            return true;
    return false;
}

bool find_u64(struct span object, const char *key, uint64_t *out)
{
    struct span value;
    return find_key(object, key, &value) &&
           number_parse_u64(value, UINT64_MAX, out);
}

bool find_number(struct span object, const char *key, double *out)
{
    struct span value;
    return find_key(object, key, &value) && number_parse(value, out);
}

bool find_bool(struct span object, const char *key, bool *out)
{
    struct span value;
    if (!find_key(object, key, &value))
        return false;
    *out = value.size == 4 && memcmp(value.data, "true", 4) == 0;
    return *out || (value.size == 5 && memcmp(value.data, "false", 5) == 0);
}

static bool hex4(struct span s, size_t at, uint32_t *out)
{
    static const char digits[] = "0123456789abcdef";
    *out = 0;
    if (s.size < 4 || at > s.size - 4)
        return false;
    for (size_t i = at; i < at + 4; i++) {
        int c = s.data[i] | 0x20; // to lower case; digits stay as they are
        const char *d = strchr(digits, c);
        if (!d)
            return false;
        *out = *out << 4 | (uint32_t)(d - digits);
    }
    return true;
}

// The character at s[*at], just after "\u"; steps over it and over the second
// half of a pair.
static uint32_t unicode(struct span s, size_t *at)
{
    uint32_t c, low;
    if (!hex4(s, *at, &c))
        return 0xfffd;
    *at += 4;
    if (c >= 0xd800 && c <= 0xdbff && s.size - *at >= 6 &&
        memcmp(s.data + *at, "\\u", 2) == 0 && hex4(s, *at + 2, &low) &&
        low >= 0xdc00 && low <= 0xdfff) {
        *at += 6;
        return 0x10000 + ((c - 0xd800) << 10) + (low - 0xdc00);
    }
    return c >= 0xd800 && c <= 0xdfff ? 0xfffd : c;
}

bool find_text(struct span value, struct buf *out)
{
    if (value.size < 2 || value.data[0] != '"' ||
        value.data[value.size - 1] != '"')
        return false;
    struct span s = {value.data + 1, value.size - 2};
    for (size_t at = 0; at < s.size;) {
        unsigned char utf8[4];
        uint32_t c = s.data[at++];
        if (c == '\\' && at < s.size) {
            c = s.data[at++];
            if (c == 'u')
                c = unicode(s, &at);
            else if (strchr("bfnrt", (int)c))
                c = ' ';
        } else if (c >= 0x80) { // a part of UTF-8, as it stands
            buf_byte(out, (unsigned char)c);
            continue;
        }
        if (c < 0x20 || c == 0x7f)
            c = ' ';
        buf_append(out, utf8, utf8_put(utf8, c));
    }
    return true;
}
