// pages.c - web/* as bytes in .rodata, by .incbin, and which path each answers
// to.  Headers and the sending are http's.
#include "server/pages.h"

#include <string.h>

#define HTML "text/html; charset=utf-8"
#define SCRIPT "text/javascript; charset=utf-8"
#define STYLE "text/css; charset=utf-8"

#define FILES(X) \
    X(index, "index.html", HTML) \
    X(app, "app.js", SCRIPT) \
    X(link, "link.js", SCRIPT) \
    X(panel, "panel.js", SCRIPT) \
    X(view, "view.js", SCRIPT) \
    X(style, "style.css", STYLE) \
    X(icon, "icon.svg", "image/svg+xml")

#define EMBED(id, file, type) \
    __asm__(".section .rodata\n" \
            "pages_" #id "_begin:\n" \
            ".incbin \"web/" file "\"\n" \
            "pages_" #id "_end:\n" \
            ".byte 0\n" \
            ".previous\n" \
            ".global pages_" #id "_begin, pages_" #id "_end\n"); \
    extern const unsigned char pages_##id##_begin[], pages_##id##_end[];
FILES(EMBED)

static const struct page {
    const char *path, *type;
    const unsigned char *begin, *end;
} pages[] = {
#define PAGE(id, file, type) \
    {"/" file, type, pages_##id##_begin, pages_##id##_end},
    FILES(PAGE)};

bool pages_find(const char *path, struct span *body, const char **content_type)
{
    if (strcmp(path, "/") == 0)
        path = "/index.html";
    for (size_t i = 0; i < sizeof pages / sizeof pages[0]; i++) {
        if (strcmp(pages[i].path, path) != 0)
            continue;
        *body = (struct span){pages[i].begin,
                              (size_t)(pages[i].end - pages[i].begin)};
        *content_type = pages[i].type;
        return true;
    }
    return false;
}
