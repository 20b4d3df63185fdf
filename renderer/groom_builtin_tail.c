// groom_builtin_tail.c - the axis of a strand that is combed back to a tie at
// the back of the head and falls from there as part of a tail.
#include "renderer/groom_builtin.h"

// Where the hair is tied: a direction on the unit sphere, and how far outside
// the head.  It leaves the tie along `leave`.
static const struct vec3 tie_dir = {0.16f, 0.82f, 0.5494f};
static const float tie_height = 1.3f;
static const struct vec3 leave = {0.28f, 0.72f, 0.635f};

// Place of the strand in the bundle: a point of the unit disc.  Hair from far
// away runs outside, hair rooted near the tie inside.
static void bundle_place(const struct groom_root *root, float *u, float *v)
{
    float along = vec_dot(root->dir, tie_dir);
    struct vec3 side = vec_unit(vec_mad(root->dir, -along, tie_dir));
    struct vec3 up = vec_unit(vec_cross(tie_dir, vec(1, 0, 0)));
    float rim = sqrtf(vec_clamp((1 - along) / 1.7f, 0, 1));
    rim = vec_clamp(rim + 0.08f * vec_signed(root->id, STREAM_BUNDLE), 0, 1);
    *u = side.x * rim;
    *v = vec_dot(side, up) * rim;
}

// Half the thickness of the tail at `s` from the tie, for a tail of `length`.
static float tail_radius(float s, float length)
{
    float open = 1.05f + 2.6f * vec_smoothstep(0, 11, s);
    float end = vec_smoothstep(0.45f * length, 1.05f * length, s);
    return open * (1 - 0.55f * end);
}

struct frame {
    struct vec3 p, t; // centre line of the tail
};

// The centre line turns from `leave` to the vertical like a bent rod that
// falls.
static struct frame tail_step(struct frame at, float s, float step)
{
    // It swings to one side and comes forward there, over a shoulder.
    float swing = vec_smoothstep(0, 6, s) - vec_smoothstep(6, 30, s);
    struct vec3 down = {0.72f * swing + 0.12f * sinf(0.2f * s),
                        -0.4f * swing + 0.08f * sinf(0.16f * s), -1};
    struct vec3 t = vec_unit(vec_mix(at.t, down, 1 - expf(-step / 5.0f)));
    return (struct frame){vec_mad(at.p, step, t), t};
}

static struct vec3 on_head(struct vec3 dir, float height)
{
    struct vec3 r = groom_builtin_head_radius, n;
    struct vec3 p = vec(dir.x * r.x, dir.y * r.y, dir.z * r.z);
    groom_builtin_head_height(p, &n);
    return vec_mad(p, height, n);
}

// Points of the way from the root to the tie, over the head.
enum { OVER_HEAD = 40 };

static void over_head(const struct groom_root *root, struct vec3 tie,
                      struct vec3 out[OVER_HEAD + 1])
{
    float whole = acosf(vec_clamp(vec_dot(root->dir, tie_dir), -1, 1));
    float sine = sinf(whole) + 1e-6f;
    float deep = vec_random(root->id, STREAM_LAYER);
    float wander =
        0.10f * groom_builtin_head_noise(vec_scale(root->p, 0.35f), 5) +
        0.02f * vec_signed(root->id, STREAM_STRAY);
    struct vec3 aside = vec_unit(vec_cross(root->dir, tie_dir));
    // The hair lies thicker the closer to the tie it comes.
    float thick = 0.25f + 0.85f * deep * vec_clamp(whole, 0.2f, 1.2f);
    if (root->fly)
        thick += 0.7f * vec_random(root->id, STREAM_STRAY2);
    for (int k = 0; k <= OVER_HEAD; k++) {
        float a = (float)k / OVER_HEAD;
        struct vec3 dir =
            vec_mad(vec_scale(root->dir, sinf((1 - a) * whole) / sine),
                    sinf(a * whole) / sine, tie_dir);
        dir = vec_unit(vec_mad(dir, wander * sinf(3.14159f * a), aside));
        float rise = vec_smoothstep(0, 0.5f, a) * thick;
        struct vec3 p = on_head(dir, 0.012f + rise);
        // The last part leaves the head and bends into the tie.
        float reach = vec_smoothstep(1 - 3.2f / (9 * whole + 3.2f), 1, a);
        out[k] = vec_mix(p, vec_mad(tie, 2.0f * (a - 1), leave), reach);
    }
    out[0] = root->p;
}

// Walks along a polyline in equal steps.
struct walker {
    struct groom_curve *curve;
    struct vec3 last;
    float left; // to the next point of the curve
};

static void walk_to(struct walker *w, struct vec3 p)
{
    struct vec3 d = vec_sub(p, w->last);
    float length = vec_length(d), at = 0;
    while (length - at >= w->left && w->curve->n < GROOM_CURVE_MAX) {
        at += w->left;
        w->curve->p[w->curve->n++] = vec_mad(w->last, at / length, d);
        w->left = w->curve->step;
    }
    w->left -= length - at;
    w->last = p;
}

static void soften(struct groom_curve *curve, int goes)
{
    for (int go = 0; go < goes; go++) {
        struct vec3 before = curve->p[0];
        for (int k = 1; k + 1 < curve->n; k++) {
            struct vec3 here = curve->p[k];
            struct vec3 middle = vec_mix(before, curve->p[k + 1], 0.5f);
            curve->p[k] = vec_mix(here, middle, 0.6f);
            before = here;
        }
    }
}

void groom_builtin_tail(const struct groom_style *style,
                        const struct groom_root *root, float length,
                        struct groom_curve *curve)
{
    curve->n = 1;
    curve->step = style->step;
    curve->p[0] = root->p;
    float u, v;
    bundle_place(root, &u, &v);
    struct vec3 across = {1, 0, 0};
    struct frame at = {on_head(tie_dir, tie_height), leave};
    struct vec3 up = vec_cross(at.t, across);
    float r = tail_radius(0, length);
    struct vec3 tie = vec_mad(vec_mad(at.p, r * u, across), r * v, up);
    struct vec3 way[OVER_HEAD + 1];
    over_head(root, tie, way);
    struct walker walker = {curve, root->p, style->step};
    for (int k = 1; k <= OVER_HEAD; k++)
        walk_to(&walker, way[k]);
    curve->tie = (float)curve->n * curve->step - walker.left;
    const float step = 0.5f;
    for (float s = step; s <= length + step; s += step) {
        at = tail_step(at, s, step);
        up = vec_cross(at.t, across);
        r = tail_radius(s, length);
        walk_to(&walker, vec_mad(vec_mad(at.p, r * u, across), r * v, up));
    }
    soften(curve, 5);
}
