// error.c - fills error values.  It prints nothing: the top does.
#include "protocol/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void blank_controls(char *s)
{
    for (; *s; s++)
        if ((unsigned char)*s < 0x20 || *s == 0x7f)
            *s = ' ';
}

bool error_set(struct error *err, const char *code, const char *name,
               const char *fmt, ...)
{
    if (!err)
        return false;
    char text[sizeof err->text]; // an argument may be err's own text
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    char named[sizeof err->name];
    snprintf(named, sizeof named, "%s", name ? name : "");
    snprintf(err->code, sizeof err->code, "%s", code);
    memcpy(err->name, named, sizeof named);
    memcpy(err->text, text, sizeof text);
    blank_controls(err->name);
    blank_controls(err->text);
    return false;
}

bool error_prefix(struct error *err, const char *prefix)
{
    if (!err)
        return false;
    char text[sizeof err->text];
    int n = snprintf(text, sizeof text, "%s: ", prefix);
    if (n > 0 && (size_t)n < sizeof text)
        snprintf(text + n, sizeof text - (size_t)n, "%s", err->text);
    memcpy(err->text, text, sizeof text);
    blank_controls(err->text);
    return false;
}
