// groom_builtin_dress.c - makes hair of axis curves: strands gather in locks
// within locks, tighter towards the tips; locks wave or curl as one; every
// strand adds its own frizz, is cut, and is laid out as points.
#include "renderer/groom_builtin.h"

#include <stdlib.h>

struct groom_dress {
    const struct groom_style *style;
    uint32_t count; // style->locks + style->sublocks
    // Locks first, then sublocks, which already follow their locks.
    struct groom_root *roots;
    struct groom_curve *curves;
};

// What the strand is, apart from where it grows.
struct strand {
    const struct groom_root *root;
    uint32_t lock, sublock; // indices of curves
    float length;
    float origin; // see wave_origin
};

static const uint32_t NO_LOCK = UINT32_MAX;

static struct vec3 curve_at(const struct groom_curve *curve, float s)
{
    float x = s / curve->step, end = (float)(curve->n - 1);
    if (x >= end) { // straight on
        struct vec3 a = curve->p[curve->n - 2], b = curve->p[curve->n - 1];
        return vec_mad(b, x - end, vec_sub(b, a));
    }
    int i = (int)x;
    return vec_mix(curve->p[i], curve->p[i + 1], x - (float)i);
}

// The nearest of roots[from .. to) on the same side of the parting.  The
// place is shaken a little so that locks have ragged borders.  NO_LOCK when
// there is none.
static uint32_t nearest(const struct groom_dress *dress, uint32_t from,
                        uint32_t to, const struct groom_root *root)
{
    float shake = 5 / sqrtf((float)(to - from) + 1);
    struct vec3 p = {
        root->p.x + shake * vec_signed(root->id, STREAM_CLUMP),
        root->p.y + shake * vec_signed(root->id, STREAM_CLUMP + 100),
        root->p.z + shake * vec_signed(root->id, STREAM_CLUMP + 200)};
    uint32_t best = NO_LOCK;
    float least = 1e30f;
    for (uint32_t i = from; i < to; i++) {
        const struct groom_root *r = &dress->roots[i];
        struct vec3 d = vec_sub(r->p, p);
        float far = vec_dot(d, d);
        bool same = r->fringe == root->fringe &&
                    (r->side == root->side || p.y > dress->style->crown + 2);
        if (far < least && same) {
            least = far;
            best = i;
        }
    }
    return best;
}

// How much of the way to the middle of its lock a strand has gone at the
// fraction `t` of its length.
static float gather(float tight, float t, uint32_t lock)
{
    float own = 0.75f + 0.45f * vec_random(lock, STREAM_CLUMP);
    float begins = 0.12f * vec_random(lock, STREAM_CLUMP + 1);
    return fminf(0.97f, tight * own * vec_smoothstep(begins - 0.05f, 1, t));
}

static void follow(const struct groom_dress *dress, uint32_t index, float tight,
                   float length, struct groom_curve *curve)
{
    if (index == NO_LOCK)
        return;
    const struct groom_curve *lock = &dress->curves[index];
    length += curve->tie;
    for (int k = 1; k < curve->n; k++) {
        float s = (float)k * curve->step;
        float there = fmaxf(0, s - curve->tie + lock->tie);
        struct vec3 middle = curve_at(lock, there);
        float g = gather(tight, fminf(1, s / length), index);
        curve->p[k] = vec_mix(curve->p[k], middle, g);
    }
}

static void grow(const struct groom_style *style, const struct groom_root *root,
                 float length, struct groom_curve *curve)
{
    if (style->tail && !root->fringe)
        groom_builtin_tail(style, root, length, curve);
    else
        groom_builtin_grow(style, root, length, curve);
}

static float length_of(const struct groom_style *style,
                       const struct groom_root *root)
{
    float patch = groom_builtin_head_noise(vec_scale(root->p, 0.5f), 21) * 0.5f;
    float own = vec_signed(root->id, STREAM_LENGTH);
    // A few are much shorter: broken, or grown later.
    if (vec_random(root->id, STREAM_LENGTH + 50) < 0.06f)
        own -= 1.5f * vec_random(root->id, STREAM_LENGTH + 51);
    float high = vec_smoothstep(-0.3f, 0.9f, root->dir.z) *
                 vec_smoothstep(0.7f, -0.6f, root->dir.y);
    float length = style->length * (1 + style->spread * (own + patch)) *
                   (1 - style->layered * high);
    if (style->tail && root->fringe) // too short for the tie
        length *= 0.6f;
    if (root->fly)
        length *= 0.45f + 0.5f * vec_random(root->id, STREAM_STRAY3);
    return fmaxf(length, 4);
}

struct groom_dress *groom_builtin_dress_create(const struct groom_style *style,
                                               const struct groom_root *roots)
{
    struct groom_dress *dress = bytes_zalloc(1, sizeof *dress);
    dress->style = style;
    dress->count = style->locks + style->sublocks;
    dress->roots = bytes_alloc(dress->count * sizeof *dress->roots);
    dress->curves = bytes_alloc(dress->count * sizeof *dress->curves);
    // Any beginning of the roots is even, and so is any stretch of them.
    for (uint32_t i = 0; i < dress->count; i++) {
        struct groom_root *root = &dress->roots[i];
        *root = roots[i];
        root->fly = false;
        float length = style->length * (1 + style->spread);
        grow(style, root, length, &dress->curves[i]);
        if (i < style->locks)
            continue;
        uint32_t lock = nearest(dress, 0, style->locks, root);
        follow(dress, lock, style->lock_tight, length, &dress->curves[i]);
    }
    return dress;
}

void groom_builtin_dress_destroy(struct groom_dress *dress)
{
    if (!dress)
        return;
    free(dress->roots);
    free(dress->curves);
    free(dress);
}

// The length at which the strand passes the height of the cut.
static float cut_at(const struct groom_style *style,
                    const struct groom_root *root,
                    const struct groom_curve *curve, float length)
{
    float height = root->fringe ? style->cut_fringe : style->cut;
    if (height < -100)
        return length;
    if (!root->fringe)
        height += style->layered * style->length *
                  vec_smoothstep(0.2f, -0.7f, root->dir.y);
    height += style->ragged * vec_signed(root->id, STREAM_CUT);
    int most = (int)(length / curve->step) + 1;
    for (int k = 1; k < curve->n && k < most; k++) {
        float a = curve->p[k - 1].z, b = curve->p[k].z;
        if (b <= height && a > height)
            return ((float)(k - 1) + (a - height) / (a - b)) * curve->step;
    }
    return length;
}

// Where along the strand its points stand: closer where the axis bends.
static void spread_points(const struct groom_curve *curve, float length,
                          uint32_t n, float *at)
{
    float sum[GROOM_CURVE_MAX];
    int last = (int)ceilf(length / curve->step);
    if (last > curve->n - 1)
        last = curve->n - 1;
    sum[0] = 0;
    for (int k = 1; k <= last; k++) {
        int i = k < curve->n - 1 ? k : curve->n - 2;
        struct vec3 bend =
            vec_mad(vec_add(curve->p[i - 1], curve->p[i + 1]), -2, curve->p[i]);
        float curvature = vec_length(bend) / (curve->step * curve->step);
        sum[k] = sum[k - 1] + 1 + 5 * fminf(curvature, 0.5f);
    }
    // The last stretch may reach beyond `length`.
    float part = length / curve->step - (float)(last - 1);
    float whole =
        sum[last - 1] + (sum[last] - sum[last - 1]) * vec_clamp(part, 0, 1);
    int k = 1;
    for (uint32_t i = 0; i < n; i++) {
        float want = whole * (float)i / (float)(n - 1);
        while (k < last && sum[k] < want)
            k++;
        at[i] = ((float)(k - 1) + (want - sum[k - 1]) / (sum[k] - sum[k - 1])) *
                curve->step;
    }
}

// The swing of a strand about its axis at one place.
struct swing {
    float aside, up;
};

// How far down from the parting, along the head, a strand is rooted (negative:
// how far from the tie).  Waves are counted from there and not from the root,
// so that hair which lies side by side waves together.
static float wave_origin(const struct groom_style *style,
                         const struct groom_root *root,
                         const struct groom_curve *curve)
{
    if (curve->tie > 0)
        return -curve->tie;
    struct vec3 r = groom_builtin_head_radius;
    float x = style->part / r.x, y = fminf(root->dir.y, style->crown / r.y);
    struct vec3 top = {x, y, sqrtf(fmaxf(0, 1 - x * x - y * y))};
    float cosine = vec_dot(vec_unit(top), root->dir);
    return 9 * acosf(vec_clamp(cosine, -1, 1));
}

static struct swing wave_at(const struct groom_style *style,
                            const struct strand *strand, float s)
{
    uint32_t lock = strand->sublock, id = strand->root->id;
    float round = style->wave_round, from = s + strand->origin;
    float size = style->wave *
                 (0.7f + 0.6f * vec_random(lock, STREAM_AMPLITUDE)) *
                 (1 + 0.15f * vec_signed(id, STREAM_AMPLITUDE)) *
                 vec_smoothstep(0.3f * style->wave_start,
                                1.7f * style->wave_start + 2, from) *
                 vec_smoothstep(0, 3, s);
    float period = style->wavelength *
                   (1 + 0.08f * vec_signed(strand->lock, STREAM_WAVELENGTH) +
                    0.2f * round * vec_signed(lock, STREAM_WAVELENGTH + 50) +
                    0.02f * vec_signed(id, STREAM_WAVELENGTH));
    if (style->tail && strand->root->fringe) { // loose strands wave freely
        size *= 1.6f;
        period *= 0.5f;
    }
    // Flat waves run through neighbouring locks; curls turn each on its own.
    float phase =
        style->phase_spread *
            groom_builtin_head_noise(vec_scale(strand->root->p, 0.16f), 31) +
        0.7f * vec_signed(strand->lock, STREAM_PHASE) +
        (0.4f + 3 * round * round) * vec_signed(lock, STREAM_PHASE + 50) +
        0.3f * vec_signed(id, STREAM_PHASE + 60);
    float x = 6.2831853f * from / period + phase;
    float turn = vec_random(lock, STREAM_PHASE + 100) < 0.5f ? -1.0f : 1.0f;
    return (struct swing){size * cosf(x), size * round * turn * sinf(x)};
}

// Two incommensurate sines per direction look irregular enough and are smooth.
static struct swing frizz_at(const struct groom_style *style,
                             const struct strand *strand, float s)
{
    uint32_t id = strand->root->id;
    float size = style->frizz * vec_smoothstep(0, strand->length, s) *
                 (0.3f + 1.4f * vec_random(id, STREAM_FRIZZ));
    float x = 6.2831853f * s / style->frizz_length;
    if (strand->root->fly) {
        size += (0.1f + 1.2f * style->frizz) * vec_smoothstep(0, 10, s);
        x *= 0.6f;
    }
    float a = 6.2831853f * vec_random(id, STREAM_FRIZZ + 1);
    float b = 6.2831853f * vec_random(id, STREAM_FRIZZ + 2);
    float c = 0.8f + 0.5f * vec_random(id, STREAM_FRIZZ + 3);
    return (struct swing){
        size * (0.7f * sinf(c * x + a) + 0.3f * sinf(2.3f * x + b)),
        size * (0.7f * sinf(0.9f * c * x + b) + 0.3f * sinf(1.9f * x - a))};
}

// Lays the strand out.  Swings are measured in a frame that is carried along
// the axis without twist, so neighbours swing the same way.
static void lay_out(const struct groom_style *style,
                    const struct strand *strand,
                    const struct groom_curve *curve, float *position,
                    uint32_t n)
{
    float at[512];
    if (n > 512)
        n = 512;
    spread_points(curve, strand->length, n, at);
    struct vec3 normal;
    groom_builtin_head_height(strand->root->p, &normal);
    struct vec3 t = vec_unit(vec_sub(curve->p[1], curve->p[0]));
    struct vec3 aside = vec_unit(vec_cross(normal, t));
    for (uint32_t i = 0; i < n; i++) {
        struct vec3 p = curve_at(curve, at[i]);
        if (i > 0) {
            t = vec_unit(vec_sub(curve_at(curve, at[i] + 0.1f),
                                 curve_at(curve, at[i] - 0.1f)));
            if (curve->tie > 0) // all of a tail swings together
                aside = vec(1, 0, 0);
            aside = vec_unit(vec_mad(aside, -vec_dot(aside, t), t));
            struct vec3 up = vec_cross(t, aside);
            struct swing w = wave_at(style, strand, at[i]);
            struct swing f = frizz_at(style, strand, at[i]);
            p = vec_mad(p, w.aside + f.aside, aside);
            p = vec_mad(p, w.up + f.up, up);
        }
        position[3 * (size_t)i] = p.x;
        position[3 * (size_t)i + 1] = p.y;
        position[3 * (size_t)i + 2] = p.z;
    }
}

void groom_builtin_dress_strand(const struct groom_dress *dress,
                                const struct groom_root *root, float *position,
                                uint32_t n)
{
    const struct groom_style *style = dress->style;
    struct strand strand = {.root = root};
    strand.lock = nearest(dress, 0, style->locks, root);
    strand.sublock = nearest(dress, style->locks, dress->count, root);
    float length = length_of(style, root);
    struct groom_curve curve;
    grow(style, root, length, &curve);
    float loose = root->fly ? 0.25f : 1;
    follow(dress, strand.lock, loose * style->lock_tight, length, &curve);
    follow(dress, strand.sublock, loose * style->sublock_tight, length, &curve);
    float whole = (float)(curve.n - 1) * curve.step;
    strand.length = style->tail ? whole : fminf(length, whole);
    strand.length = cut_at(style, root, &curve, strand.length);
    strand.origin = wave_origin(style, root, &curve);
    lay_out(style, &strand, &curve, position, n);
    groom_builtin_head_keep_out(position, n);
}
