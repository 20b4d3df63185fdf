// log.c - one write per line, so that lines of two threads do not mix.
#include "server/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

void log_line(const char *fmt, ...)
{
    char line[512] = "glintd: ";
    size_t begin = strlen(line);
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(line + begin, sizeof line - begin - 1, fmt, ap);
    va_end(ap);
    size_t n = strlen(line);
    for (size_t i = begin; i < n; i++)
        if ((unsigned char)line[i] < 0x20 || line[i] == 0x7f)
            line[i] = ' ';
    line[n++] = '\n';
    if (write(STDERR_FILENO, line, n) < 0)
        return; // nobody reads: nothing to be done about it
}
