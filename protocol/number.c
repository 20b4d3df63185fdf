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

// The significant digits of a number and where its point is: 0.d1d2... x 10^e.
struct decimal {
    char digit[20];
    int count, exponent;
    bool negative;
};

// From printf's "-1.5e-07".  Its decimal point, of one byte or more, is that
// of the locale which the process has chosen: whatever is no digit is skipped.
static void read_decimal(struct decimal *d, const char *text)
{
    const char *e = strchr(text, 'e');
    *d = (struct decimal){.negative = text[0] == '-'};
    for (const char *c = text; c < e; c++)
        if (*c >= '0' && *c <= '9')
            d->digit[d->count++] = *c;
    d->exponent = atoi(e + 1) + 1;
}

// Plain where a person would write it so, else with an exponent.
static size_t lay_out(const struct decimal *d, char out[NUMBER_BUFFER])
{
    const char *sign = d->negative ? "-" : "";
    int whole = d->exponent, n = d->count;
    int length;
    if (whole > 0 && whole <= 21 && n <= whole) // 1200
        length = snprintf(out, NUMBER_BUFFER, "%s%.*s%.*s", sign, n, d->digit,
                          whole - n, "00000000000000000000");
    else if (whole > 0 && whole <= 21) // 12.5
        length = snprintf(out, NUMBER_BUFFER, "%s%.*s.%.*s", sign, whole,
                          d->digit, n - whole, d->digit + whole);
    else if (whole <= 0 && whole > -6) // 0.00125
        length = snprintf(out, NUMBER_BUFFER, "%s0.%.*s%.*s", sign, -whole,
                          "000000", n, d->digit);
    else // 1.25e-30
        length =
            snprintf(out, NUMBER_BUFFER, "%s%c%s%.*se%d", sign, d->digit[0],
                     n > 1 ? "." : "", n - 1, d->digit + 1, whole - 1);
    return (size_t)length;
}

// With `precision` significant digits; returns what reads back.
static double print_with(int precision, double value, char out[NUMBER_BUFFER],
                         size_t *length)
{
    char raw[64];
    double back = 0;
    struct decimal d;
    snprintf(raw, sizeof raw, "%.*e", precision - 1, value);
    read_decimal(&d, raw);
    *length = lay_out(&d, out);
    number_parse((struct span){(const unsigned char *)out, *length}, &back);
    return back;
}

size_t number_print_float(char out[NUMBER_BUFFER], float value)
{
    size_t length = 0;
    for (int precision = 1; precision <= 9; precision++)
        if ((float)print_with(precision, (double)value, out, &length) == value)
            break;
    return length;
}

size_t number_print(char out[NUMBER_BUFFER], double value)
{
    size_t length = 0;
    for (int precision = 1; precision <= 17; precision++)
        if (print_with(precision, value, out, &length) == value)
            break;
    return length;
}
