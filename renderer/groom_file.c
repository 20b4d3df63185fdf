// groom_file.c - reads .hair files (layout: docs/FORMATS.md).  Every count is
// checked against its limit and against the file's length before anything is
// allocated; every value is checked before it is stored.  The bytes are copied
// and never cast: an odd number of strands leaves the floats after the segment
// counts on a 2-byte boundary.
#include "renderer/groom.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "renderer/groom_private.h"

enum {
    HEADER_SIZE = 128,
    HAS_SEGMENTS = 1,
    HAS_POINTS = 2,
    HAS_THICKNESS = 4,
    HAS_TRANSPARENCY = 8,
    HAS_COLOURS = 16,
    HAS_ALL = 31,
};

// Coordinates and thicknesses above this would overflow when squared sums of
// them are taken in single precision.
static const float far_away = 1e9f;
static const float brightest = 1000;

struct header {
    uint32_t strands, points, arrays, segments;
    float thickness, transparency, colour[3];
};

// Where the arrays stand in the file; NULL when the file has none.
struct layout {
    const unsigned char *segments, *points, *thickness, *transparency, *colours;
};

static uint32_t u32_at(const unsigned char *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

static uint32_t u16_at(const unsigned char *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8;
}

static float f32_at(const unsigned char *p)
{
    uint32_t bits = u32_at(p);
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static bool check_header(const struct header *h, const char *name,
                         struct error *err)
{
    if (h->arrays & ~(uint32_t)HAS_ALL)
        return error_set(err, "file", name,
                         "%s: the array flags are 0x%x; only the bits of 0x1f "
                         "are known",
                         name, (unsigned)h->arrays);
    if (!(h->arrays & HAS_POINTS))
        return error_set(err, "file", name,
                         "%s: the array flags are 0x%x; without 0x2 the file "
                         "has no points",
                         name, (unsigned)h->arrays);
    if (h->points < 2 || h->points > GROOM_MAX_POINTS)
        return error_set(err, h->points < 2 ? "file" : "limit", name,
                         "%s: the header counts %u points, not within "
                         "[2, %u]",
                         name, (unsigned)h->points, GROOM_MAX_POINTS);
    if (h->strands < 1 || h->strands > h->points)
        return error_set(err, "file", name,
                         "%s: the header counts %u strands, not within "
                         "[1, %u], the number of its points",
                         name, (unsigned)h->strands, (unsigned)h->points);
    if (h->arrays & HAS_SEGMENTS)
        return true;
    uint64_t sum = (uint64_t)h->strands * ((uint64_t)h->segments + 1);
    if (sum != h->points)
        return error_set(err, "file", name,
                         "%s: %u strands of %u segments have %llu points, "
                         "but the header counts %u",
                         name, (unsigned)h->strands, (unsigned)h->segments,
                         (unsigned long long)sum, (unsigned)h->points);
    return true;
}

static bool read_header(struct span file, struct header *h, const char *name,
                        struct error *err)
{
    if (file.size > GROOM_MAX_BYTES)
        return error_set(err, "limit", name,
                         "%s: %zu bytes are more than the limit of %u", name,
                         file.size, GROOM_MAX_BYTES);
    if (file.size < HEADER_SIZE)
        return error_set(err, "file", name,
                         "%s: %zu bytes are no .hair file, whose header alone "
                         "has %d",
                         name, file.size, HEADER_SIZE);
    const unsigned char *p = file.data;
    if (memcmp(p, "HAIR", 4) != 0)
        return error_set(err, "file", name,
                         "%s: begins with %02x %02x %02x %02x, not with the "
                         "word HAIR",
                         name, p[0], p[1], p[2], p[3]);
    h->strands = u32_at(p + 4);
    h->points = u32_at(p + 8);
    h->arrays = u32_at(p + 12);
    h->segments = u32_at(p + 16);
    h->thickness = f32_at(p + 20);
    h->transparency = f32_at(p + 24);
    for (int c = 0; c < 3; c++)
        h->colour[c] = f32_at(p + 28 + 4 * c);
    return check_header(h, name, err);
}

static bool find_arrays(struct span file, const struct header *h,
                        struct layout *l, const char *name, struct error *err)
{
    // Both counts are at most 8 M here: the sum stays below 2^29.
    const size_t sizes[5] = {
        (h->arrays & HAS_SEGMENTS) ? (size_t)h->strands * 2 : 0,
        (size_t)h->points * 12,
        (h->arrays & HAS_THICKNESS) ? (size_t)h->points * 4 : 0,
        (h->arrays & HAS_TRANSPARENCY) ? (size_t)h->points * 4 : 0,
        (h->arrays & HAS_COLOURS) ? (size_t)h->points * 12 : 0,
    };
    const unsigned char **const arrays[5] = {
        &l->segments, &l->points, &l->thickness, &l->transparency, &l->colours,
    };
    size_t want = HEADER_SIZE;
    for (int i = 0; i < 5; i++)
        want += sizes[i];
    if (file.size != want)
        return error_set(err, "file", name,
                         "%s: the header describes %zu bytes, but the file "
                         "has %zu",
                         name, want, file.size);
    const unsigned char *at = file.data + HEADER_SIZE;
    for (int i = 0; i < 5; at += sizes[i++])
        *arrays[i] = sizes[i] > 0 ? at : NULL;
    return true;
}

static uint32_t segments_of(const struct header *h, const struct layout *l,
                            uint32_t strand)
{
    return l->segments ? u16_at(l->segments + 2 * (size_t)strand) : h->segments;
}

// The strands with at least two points, and how many points they have.
struct kept {
    uint32_t strands, points;
};

static bool count_strands(const struct header *h, const struct layout *l,
                          struct kept *kept, const char *name,
                          struct error *err)
{
    uint64_t sum = 0;
    *kept = (struct kept){0};
    for (uint32_t s = 0; s < h->strands; s++) {
        uint32_t n = segments_of(h, l, s);
        sum += (uint64_t)n + 1;
        if (n > 0 && sum <= h->points) {
            kept->strands++;
            kept->points += n + 1;
        }
    }
    if (sum != h->points)
        return error_set(err, "file", name,
                         "%s: the segments of its %u strands make %llu "
                         "points, but the header counts %u",
                         name, (unsigned)h->strands, (unsigned long long)sum,
                         (unsigned)h->points);
    if (kept->strands == 0)
        return error_set(err, "file", name,
                         "%s: none of its %u strands has two points", name,
                         (unsigned)h->strands);
    return true;
}

// One array of the file: `width` floats per point, all within [low, high].
struct channel {
    const unsigned char *from;
    const char *what;
    size_t width;
    float low, high;
};

static bool bad_value(const struct channel *ch, size_t at, const char *name,
                      struct error *err)
{
    float v = f32_at(ch->from + 4 * at);
    return error_set(err, "file", name,
                     "%s: the %s of point %zu is %g, not within [%g, %g]", name,
                     ch->what, at / ch->width, (double)v, (double)ch->low,
                     (double)ch->high);
}

// Checks every value and copies those of the strands that are kept.
static bool copy_channel(const struct header *h, const struct layout *l,
                         const struct channel *ch, float *to, const char *name,
                         struct error *err)
{
    size_t at = 0;
    for (uint32_t s = 0; s < h->strands; s++) {
        uint32_t n = segments_of(h, l, s);
        size_t end = at + ((size_t)n + 1) * ch->width;
        for (; at < end; at++) {
            float v = f32_at(ch->from + 4 * at);
            if (!(v >= ch->low && v <= ch->high)) // a NaN is neither
                return bad_value(ch, at, name, err);
            if (n > 0)
                *to++ = v;
        }
    }
    return true;
}

static void fill_first(struct groom *g, const struct header *h,
                       const struct layout *l)
{
    uint32_t at = 0, kept = 0;
    for (uint32_t s = 0; s < h->strands; s++) {
        uint32_t n = segments_of(h, l, s);
        if (n == 0)
            continue;
        g->first[kept++] = at;
        at += n + 1;
    }
    g->first[kept] = at;
}

static float *new_array(const struct groom *g, size_t width)
{
    return bytes_alloc((size_t)g->points * width * sizeof(float));
}

static bool any_positive(const float *v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (v[i] > 0)
            return true;
    return false;
}

static bool copy_arrays(struct groom *g, const struct header *h,
                        const struct layout *l, struct error *err)
{
    struct channel ch = {l->points, "position", 3, -far_away, far_away};
    if (!copy_channel(h, l, &ch, g->position, g->name, err))
        return false;
    if (l->thickness) {
        g->diameter = new_array(g, 1);
        ch = (struct channel){l->thickness, "thickness", 1, 0, far_away};
        if (!copy_channel(h, l, &ch, g->diameter, g->name, err))
            return false;
        if (!any_positive(g->diameter, g->points)) {
            free(g->diameter); // all zero says no more than no array
            g->diameter = NULL;
        }
    }
    if (l->transparency) {
        g->opacity = new_array(g, 1);
        ch = (struct channel){l->transparency, "transparency", 1, 0, 1};
        if (!copy_channel(h, l, &ch, g->opacity, g->name, err))
            return false;
        for (size_t i = 0; i < g->points; i++)
            g->opacity[i] = 1 - g->opacity[i];
    }
    if (l->colours) {
        g->colour = new_array(g, 3);
        ch = (struct channel){l->colours, "colour", 3, 0, brightest};
        if (!copy_channel(h, l, &ch, g->colour, g->name, err))
            return false;
    }
    return true;
}

// A default is looked at only where it stands in for an array: writers leave
// anything in the others.
static bool check_default(float v, float high, const char *what,
                          const char *name, struct error *err)
{
    if (v >= 0 && v <= high)
        return true;
    return error_set(err, "file", name,
                     "%s: the default %s is %g, not within [0, %g]", name, what,
                     (double)v, (double)high);
}

static bool copy_defaults(struct groom *g, const struct header *h,
                          const struct layout *l, struct error *err)
{
    if (!l->thickness) {
        if (!check_default(h->thickness, far_away, "thickness", g->name, err))
            return false;
        // 1 is what writers leave who have no thickness to tell.
        g->default_diameter = h->thickness == 1 ? 0 : h->thickness;
    }
    if (!l->transparency) {
        if (!check_default(h->transparency, 1, "transparency", g->name, err))
            return false;
        g->default_opacity = 1 - h->transparency;
    }
    for (int c = 0; c < 3 && !l->colours; c++) {
        if (!check_default(h->colour[c], brightest, "colour", g->name, err))
            return false;
        g->default_colour[c] = h->colour[c];
    }
    return true;
}

static const char *without_folders(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

struct groom *groom_parse(struct span file, const char *name, struct error *err)
{
    name = without_folders(name);
    struct header h;
    struct layout l;
    struct kept kept;
    if (!read_header(file, &h, name, err) ||
        !find_arrays(file, &h, &l, name, err) ||
        !count_strands(&h, &l, &kept, name, err))
        return NULL;
    struct groom *g = groom_private_new(name, kept.strands, kept.points);
    if (!copy_defaults(g, &h, &l, err) || !copy_arrays(g, &h, &l, err)) {
        groom_destroy(g);
        return NULL;
    }
    fill_first(g, &h, &l);
    groom_private_measure(g, true);
    return g;
}

static bool read_all(int fd, unsigned char *to, size_t size, const char *name,
                     struct error *err)
{
    for (size_t have = 0; have < size;) {
        ssize_t n = read(fd, to + have, size - have);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return error_set(err, "file", name, "%s: %s", name,
                             strerror(errno));
        if (n == 0)
            return error_set(err, "file", name,
                             "%s: ends after %zu of its %zu bytes", name, have,
                             size);
        have += (size_t)n;
    }
    return true;
}

static struct groom *load_open(int fd, const char *name, struct error *err)
{
    struct stat st;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode)) {
        error_set(err, "file", name, "%s: is not a regular file", name);
        return NULL;
    }
    if (st.st_size > (off_t)GROOM_MAX_BYTES) {
        error_set(err, "limit", name,
                  "%s: %lld bytes are more than the limit of %u", name,
                  (long long)st.st_size, GROOM_MAX_BYTES);
        return NULL;
    }
    size_t size = (size_t)st.st_size;
    unsigned char *data = bytes_alloc(size + 1);
    struct groom *g = NULL;
    if (read_all(fd, data, size, name, err))
        g = groom_parse((struct span){data, size}, name, err);
    free(data);
    return g;
}

struct groom *groom_load(const char *path, struct error *err)
{
    const char *name = without_folders(path);
    // O_NONBLOCK: a pipe that nobody writes to is refused, not waited for.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        error_set(err, "file", name, "%s: %s", path, strerror(errno));
        return NULL;
    }
    struct groom *g = load_open(fd, name, err);
    close(fd);
    return g;
}
