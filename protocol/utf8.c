// utf8.c - what is and what is not UTF-8.  Nothing is repaired here.
#include "protocol/utf8.h"

#include <string.h>

static bool follows(unsigned char c)
{
    return (c & 0xc0) == 0x80;
}

size_t utf8_next(struct span text)
{
    const unsigned char *p = text.data;
    if (text.size == 0)
        return 0;
    if (p[0] < 0x80)
        return 1;
    // C0 and C1 could only begin over-long forms, F5 and up pass U+10FFFF.
    if (p[0] < 0xc2 || p[0] > 0xf4)
        return 0;
    size_t n = p[0] < 0xe0 ? 2 : p[0] < 0xf0 ? 3 : 4;
    if (text.size < n)
        return 0;
    for (size_t i = 1; i < n; i++)
        if (!follows(p[i]))
            return 0;
    if ((p[0] == 0xe0 && p[1] < 0xa0) || // over-long
        (p[0] == 0xed && p[1] > 0x9f) || // surrogates
        (p[0] == 0xf0 && p[1] < 0x90) || // over-long
        (p[0] == 0xf4 && p[1] > 0x8f))   // above U+10FFFF
        return 0;
    return n;
}

bool utf8_valid(struct span text)
{
    while (text.size > 0) {
        size_t n = utf8_next(text);
        if (n == 0)
            return false;
        text.data += n;
        text.size -= n;
    }
    return true;
}

size_t utf8_cut(struct span text, size_t limit)
{
    if (text.size <= limit)
        return text.size;
    while (limit > 0 && follows(text.data[limit]))
        limit--;
    return limit;
}

size_t utf8_put(unsigned char out[4], uint32_t c)
{
    static const unsigned char first[] = {0, 0, 0xc0, 0xe0, 0xf0};
    size_t n = c < 0x80 ? 1 : c < 0x800 ? 2 : c < 0x10000 ? 3 : 4;
    for (size_t i = n - 1; i > 0; i--, c >>= 6)
        out[i] = (unsigned char)(0x80 | (c & 0x3f));
    out[0] = (unsigned char)(first[n] | c);
    return n;
}
