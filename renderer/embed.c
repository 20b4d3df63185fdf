// embed.c - shaders/* as bytes in .rodata, by .incbin.  gen/shader_list.h has
// a line SHADER(symbol, "file") for each.
#include "renderer/embed.h"

#include <string.h>

#define SHADER(id, file) \
    __asm__(".section .rodata\n" \
            "embed_" #id "_begin:\n" \
            ".incbin \"shaders/" file "\"\n" \
            "embed_" #id "_end:\n" \
            ".byte 0\n" \
            ".previous\n" \
            ".global embed_" #id "_begin, embed_" #id "_end\n"); \
    extern const unsigned char embed_##id##_begin[], embed_##id##_end[];
#include "shader_list.h"
#undef SHADER

struct embed_entry {
    const char *name;
    const unsigned char *begin, *end;
};

static const struct embed_entry entries[] = {
#define SHADER(id, file) {file, embed_##id##_begin, embed_##id##_end},
#include "shader_list.h"
#undef SHADER
};

struct span embed_shader(const char *name)
{
    for (size_t i = 0; i < sizeof entries / sizeof entries[0]; i++)
        if (strcmp(entries[i].name, name) == 0)
            return (struct span){entries[i].begin,
                                 (size_t)(entries[i].end - entries[i].begin)};
    return (struct span){0};
}
