// front_read.c - reads fronts, from a file and from what ships with the
// program. One bad line and nothing of the file is taken.
#include "server/front.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/edit.h"
#include "protocol/line.h"
#include "protocol/number.h"
#include "server/cache.h"
#include "server/log.h"

__asm__(".section .rodata\n"
        "front_text_begin:\n"
        ".incbin \"server/front.txt\"\n"
        "front_text_end:\n"
        ".byte 0\n"
        ".previous\n"
        ".global front_text_begin, front_text_end\n");
extern const unsigned char front_text_begin[], front_text_end[];

struct reader {
    const char *name;
    int number; // of the line
    struct line line;
    bool used[LINE_PAIRS_MAX];
    struct fronts found;
};

static bool wrong(const struct reader *r, const char *what, struct error *err)
{
    return error_set(err, "front", r->name, "%s:%d: %s", r->name, r->number,
                     what);
}

static const struct line_pair *pair(struct reader *r, const char *name,
                                    struct error *err)
{
    const struct line_pair *p = line_pair(&r->line, name);
    if (p) {
        r->used[p - r->line.pairs] = true;
    } else {
        char text[96];
        snprintf(text, sizeof text, "there is no %s=", name);
        wrong(r, text, err);
    }
    return p;
}

static bool text(struct reader *r, const char *name, char *out, size_t room,
                 struct error *err)
{
    const struct line_pair *p = pair(r, name, err);
    if (!p)
        return false;
    snprintf(out, room, "%.*s", (int)p->value.size,
             (const char *)p->value.data);
    return true;
}

static bool number(struct reader *r, const char *name, double most, double *out,
                   struct error *err)
{
    const struct line_pair *p = pair(r, name, err);
    char why[96];
    if (!p)
        return false;
    if (number_parse(p->value, out) && *out > 0 && *out <= most)
        return true;
    snprintf(why, sizeof why, "%s is not a number within (0, %g]", name, most);
    return wrong(r, why, err);
}

static bool all_used(struct reader *r, struct error *err)
{
    char why[96];
    for (int i = 0; i < r->line.pair_count; i++) {
        if (r->used[i])
            continue;
        snprintf(why, sizeof why, "'%.*s' belongs to no front",
                 (int)r->line.pairs[i].name.size,
                 (const char *)r->line.pairs[i].name.data);
        return wrong(r, why, err);
    }
    return true;
}

static bool read_row(struct reader *r, struct error *err)
{
    if (r->found.count == 0)
        return wrong(r, "a row before any front", err);
    struct front *f = &r->found.item[r->found.count - 1];
    if (f->rows == FRONT_ROWS_MAX)
        return wrong(r, "more rows than a front may have", err);
    struct front_row *row = &f->row[f->rows];
    struct params p;
    params_defaults(&p);
    for (int k = 0; k < FRONT_KNOBS; k++) {
        const struct line_pair *knob = line_pair(&r->line, front_knob_names[k]);
        struct error why = {0};
        if (knob && !edit_apply(&p, knob, 1, &why))
            return wrong(r, why.text, err);
        if (knob)
            r->used[knob - r->line.pairs] = true;
        row->knob[k] = front_knob(&p, k);
    }
    for (int e = 0; e < FRONT_EDITS; e++)
        if (!number(r, front_time_names[e], 1e7, &row->first_ms[e], err))
            return false;
    if (!number(r, "rest_ms", 1e7, &row->rest_ms, err) ||
        !number(r, "error", 1e6, &row->error, err) || !all_used(r, err))
        return false;
    f->rows++;
    return true;
}

static bool read_front(struct reader *r, struct error *err)
{
    if (r->found.count == FRONT_MAX)
        return wrong(r, "more fronts than a file may have", err);
    struct front f = {0};
    double cores, strands;
    if (!text(r, "device", f.device, sizeof f.device, err) ||
        !text(r, "scene", f.scene, sizeof f.scene, err) ||
        !text(r, "hair", f.hair, sizeof f.hair, err) ||
        !text(r, "env", f.env, sizeof f.env, err) ||
        !number(r, "cores", 65536, &cores, err) ||
        !number(r, "strands", 1e9, &strands, err) || !all_used(r, err))
        return false;
    f.cores = (int)cores;
    f.strands = (uint32_t)strands;
    const size_t count = (size_t)r->found.count + 1;
    r->found.item = bytes_realloc(r->found.item, count * sizeof f);
    r->found.item[r->found.count++] = f;
    return true;
}

static bool read_line(struct reader *r, struct span line, struct error *err)
{
    struct error why = {0};
    if (line.size == 0 || line.data[0] == '#')
        return true;
    memset(r->used, 0, sizeof r->used);
    if (!line_parse(&r->line, line, &why))
        return wrong(r, why.text, err);
    if (r->line.word_count > 0)
        return wrong(r, "a word that is no pair", err);
    if (line_is(r->line.verb, "front"))
        return read_front(r, err);
    if (line_is(r->line.verb, "row"))
        return read_row(r, err);
    return wrong(r, "neither front nor row", err);
}

static bool read_lines(struct reader *r, struct span text, struct error *err)
{
    const size_t magic = strlen(front_magic);
    r->number = 1;
    if (text.size < magic || memcmp(text.data, front_magic, magic) != 0)
        return wrong(r, "it does not begin as a front of this version", err);
    const unsigned char *at = text.data + magic, *end = text.data + text.size;
    while (at < end) {
        const unsigned char *stop = memchr(at, '\n', (size_t)(end - at));
        r->number++;
        if (!stop)
            return wrong(r, "the last line has no end", err);
        if (!read_line(r, (struct span){at, (size_t)(stop - at)}, err))
            return false;
        at = stop + 1;
    }
    for (int i = 0; i < r->found.count; i++)
        if (r->found.item[i].rows == 0)
            return wrong(r, "a front without a row", err);
    return true;
}

bool fronts_parse(struct fronts *f, struct span text, const char *name,
                  struct error *err)
{
    struct reader *r = bytes_zalloc(1, sizeof *r);
    r->name = name;
    bool ok = read_lines(r, text, err);
    const size_t n = (size_t)(ok ? r->found.count : 0);
    if (n > 0) {
        f->item =
            bytes_realloc(f->item, ((size_t)f->count + n) * sizeof *f->item);
        memcpy(f->item + f->count, r->found.item, n * sizeof *f->item);
        f->count += (int)n;
    }
    line_finish(&r->line);
    fronts_finish(&r->found);
    free(r);
    return ok;
}

bool fronts_load(struct fronts *f, const char *path, struct error *err)
{
    FILE *in = fopen(path, "rb");
    if (!in)
        return error_set(err, "file", path, "%s: %s", path, strerror(errno));
    struct buf text = {0};
    size_t got = 1;
    while (got > 0 && text.size <= FRONT_BYTES_MAX) {
        unsigned char part[4096];
        got = fread(part, 1, sizeof part, in);
        buf_append(&text, part, got);
    }
    bool ok = !ferror(in);
    fclose(in);
    if (!ok)
        error_set(err, "file", path, "%s cannot be read", path);
    else if (text.size > FRONT_BYTES_MAX)
        ok = error_set(err, "limit", path, "%s: more than %d bytes", path,
                       FRONT_BYTES_MAX);
    else
        ok = fronts_parse(f, (struct span){text.data, text.size}, path, err);
    buf_finish(&text);
    return ok;
}

void fronts_shipped(struct fronts *f)
{
    const int before = f->count;
    fronts_parse(f,
                 (struct span){front_text_begin,
                               (size_t)(front_text_end - front_text_begin)},
                 "server/front.txt", NULL); // a test holds that it is sound
    for (int i = before; i < f->count; i++)
        f->item[i].shipped = true;
}

char *front_cache_path(void)
{
    char *directory = cache_directory();
    struct buf path = {0};
    if (directory)
        buf_printf(&path, "%s/front.txt%c", directory, 0);
    free(directory);
    return (char *)path.data;
}

bool fronts_open(struct fronts *f, const char *path, struct error *err)
{
    struct error why = {0};
    char *own = path ? NULL : front_cache_path();
    bool ok = !path || fronts_load(f, path, err);
    // A cache is not worth a daemon that does not start.
    if (own && access(own, F_OK) == 0 && !fronts_load(f, own, &why))
        log_line("%s; going by what ships with the program", why.text);
    free(own);
    fronts_shipped(f);
    return ok;
}
