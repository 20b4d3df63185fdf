// args.c - typed values out of the words and pairs of a request.
#include "server/args.h"

#include <string.h>

#include "protocol/edit.h"
#include "protocol/number.h"
#include "protocol/params.h"

static bool listed(const char *names, struct span name)
{
    for (const char *at = names; *at;) {
        size_t n = strcspn(at, " ");
        if (n == name.size && memcmp(at, name.data, n) == 0)
            return true;
        at += n;
        at += strspn(at, " ");
    }
    return false;
}

bool args_no_words(const struct line *line, struct error *err)
{
    if (line->word_count == 0)
        return true;
    return error_set(err, "syntax", "", "%.*s takes no word, as '%.*s'",
                     ARGS_TEXT(line->verb), ARGS_TEXT(line->words[0]));
}

bool args_pairs(const struct line *line, const char *names, struct error *err)
{
    for (int i = 0; i < line->pair_count; i++) {
        struct span name = line->pairs[i].name;
        char text[LINE_NAME_MAX + 1] = "";
        memcpy(text, name.data,
               name.size < LINE_NAME_MAX ? name.size : LINE_NAME_MAX);
        if (!listed(names, name))
            return error_set(err, "unknown", text, "%.*s knows no '%s='%s%s",
                             ARGS_TEXT(line->verb), text,
                             names[0] ? "; it knows " : "", names);
    }
    return true;
}

bool args_only(const struct line *line, const char *names, struct error *err)
{
    return args_no_words(line, err) && args_pairs(line, names, err);
}

bool args_whole(const struct line *line, const char *name,
                struct args_range range, uint64_t *to, struct error *err)
{
    const struct line_pair *pair = line_pair(line, name);
    if (!pair)
        return true;
    uint64_t v;
    if (!number_parse_u64(pair->value, UINT64_MAX, &v))
        return error_set(err, "type", name, "%s: '%.*s' is not a whole number",
                         name, ARGS_TEXT(pair->value));
    if (v < range.min || v > range.max)
        return error_set(err, "range", name,
                         "%s: %llu is not within [%llu, %llu]", name,
                         (unsigned long long)v, (unsigned long long)range.min,
                         (unsigned long long)range.max);
    *to = v;
    return true;
}

// One of the words of a choice of the parameter table.
static bool choice(const struct line *line, const char *name, const char *param,
                   int *to, struct error *err)
{
    const struct line_pair *pair = line_pair(line, name);
    const struct params_row *row = params_find(param, strlen(param));
    if (!pair)
        return true;
    for (int i = 0; edit_choice(row, i).size > 0; i++) {
        struct span word = edit_choice(row, i);
        if (word.size == pair->value.size &&
            memcmp(word.data, pair->value.data, word.size) == 0) {
            *to = i;
            return true;
        }
    }
    return error_set(err, "type", name, "%s: '%.*s' is not one of %s", name,
                     ARGS_TEXT(pair->value), row->choices);
}

// format= quality= chroma= depth=
bool args_encoding(const struct line *line, struct still_encoding *how,
                   struct error *err)
{
    uint64_t quality = (uint64_t)how->quality;
    if (!choice(line, "format", "output.format", &how->format, err) ||
        !args_whole(line, "quality", (struct args_range){1, 100}, &quality,
                    err) ||
        !choice(line, "chroma", "output.chroma", &how->chroma, err) ||
        !choice(line, "depth", "output.depth", &how->depth, err))
        return false;
    how->quality = (int)quality;
    return true;
}

bool args_layers(const struct line *line, struct still_encoding *how,
                 struct error *err)
{
    const struct line_pair *pair = line_pair(line, "layers");
    if (!pair)
        return true;
    how->layers = line_is(pair->value, "on");
    if (!how->layers && !line_is(pair->value, "off"))
        return error_set(err, "type", "layers",
                         "layers: '%.*s' is not on or "
                         "off",
                         ARGS_TEXT(pair->value));
    if (how->layers && how->format != STILL_EXR)
        return error_set(err, "syntax", "layers",
                         "layers: only format=exr has them, not %s",
                         still_format_name(how->format));
    return true;
}
