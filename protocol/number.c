// number.c - text to number and back.  The grammar is checked here, the digits
// are left to the C library's correctly rounding conversions in the C locale.
#include "protocol/number.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t digits(struct span s, size_t at)
{
    size_t n = 0;
    while (at + n < s.size && s.data[at + n] >= '0' && s.data[at + n] <= '9')
        n++;
    return n;
}

static bool sign_at(struct span s, size_t at)
{
    return at < s.size && (s.data[at] == '-' || s.data[at] == '+');
}

static bool well_formed(struct span s)
{
    size_t at = sign_at(s, 0), n = digits(s, at);
    if (n == 0)
        return false;
    at += n;
    if (at < s.size && s.data[at] == '.') {
        n = digits(s, ++at);
        if (n == 0)
            return false;
        at += n;
    }
    if (at < s.size && (s.data[at] == 'e' || s.data[at] == 'E')) {
        at++;
        at += sign_at(s, at);
        n = digits(s, at);
        if (n == 0)
            return false;
        at += n;
    }
    return at == s.size;
}

bool number_parse(struct span text, double *out)
{
    char copy[NUMBER_TEXT_MAX + 1];
    if (text.size == 0 || text.size > NUMBER_TEXT_MAX || !well_formed(text))
        return false;
    memcpy(copy, text.data, text.size);
    copy[text.size] = 0;
    // The C locale is a constant of the library: nothing to free.
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    double value = strtod_l(copy, NULL, c_locale);
    if (!isfinite(value))
        return false;
    *out = value;
    return true;
}

bool number_parse_u64(struct span text, uint64_t max, uint64_t *out)
{
    uint64_t value = 0;
    if (text.size == 0 || digits(text, 0) != text.size)
        return false;
    for (size_t i = 0; i < text.size; i++) {
        uint64_t digit = (uint64_t)(text.data[i] - '0');
        if (digit > max || value > (max - digit) / 10)
            return false;
        value = value * 10 + digit;
    }
    *out = value;
    return true;
}

// printf writes the decimal point of the locale that the process has chosen,
// of one or more bytes, and exponents with a sign and two digits: "1,5e+07"
// becomes "1.5e7".
static size_t tidy(char *text)
{
    size_t to = 0;
    for (size_t i = 0; text[i]; i++) {
        char c = text[i];
        if (strchr("0123456789-e", c)) {
            text[to++] = c;
        } else if (c != '+' && (to == 0 || text[to - 1] != '.')) {
            text[to++] = '.';
        }
        if (c == 'e') {
            if (text[i + 1] == '-')
                text[to++] = '-';
            i++; // the sign, which printf always writes
            while (text[i + 1] == '0' && text[i + 2])
                i++;
        }
    }
    text[to] = 0;
    return to;
}

// Whole numbers that are easily read keep all their digits: 1000, not 1e3.
static bool plain_whole(double value, double below)
{
    return value == trunc(value) && fabs(value) < below;
}

size_t number_print_float(char out[NUMBER_BUFFER], float value)
{
    double back = 0;
    if (plain_whole((double)value, 1e7)) {
        snprintf(out, NUMBER_BUFFER, "%.0f", (double)value);
        return strlen(out);
    }
    for (int precision = 1; precision <= 9; precision++) {
        snprintf(out, NUMBER_BUFFER, "%.*g", precision, (double)value);
        struct span text = {(const unsigned char *)out, tidy(out)};
        if (number_parse(text, &back) && (float)back == value)
            break;
    }
    return strlen(out);
}

size_t number_print(char out[NUMBER_BUFFER], double value)
{
    double back = 0;
    if (plain_whole(value, 1e15)) {
        snprintf(out, NUMBER_BUFFER, "%.0f", value);
        return strlen(out);
    }
    for (int precision = 1; precision <= 17; precision++) {
        snprintf(out, NUMBER_BUFFER, "%.*g", precision, value);
        struct span text = {(const unsigned char *)out, tidy(out)};
        if (number_parse(text, &back) && back == value)
            break;
    }
    return strlen(out);
}
