// groom_builtin_grow.c - the axis of a strand that leaves its root and falls.
// Step by step the strand turns, as fast as its stiffness lets it, towards
// what pulls at it: the comb near the root, gravity and wind further out; it
// slides over the head, and over neck and shoulders, which nobody sees but the
// hair.  Locks and waves come later, in groom_builtin_dress.c.
#include "renderer/groom_builtin.h"

// The neck, which long hair falls around.
static const struct vec3 neck_centre = {0, 2.2f, -14};
static const struct vec3 neck_radius = {5.6f, 5.8f, 13};

// The direction in which the comb leaves the hair at `p`.
static struct vec3 comb_at(const struct groom_style *style,
                           const struct groom_root *root, struct vec3 p,
                           struct vec3 n)
{
    if (root->fringe && style->tail)
        return vec_unit(vec(0.5f * root->side, -0.25f, -0.5f));
    if (root->fringe)
        return vec_unit(vec(0.22f * p.x, -1, 0));
    // Away from the parting, and from the crown where the parting ends.
    float behind = vec_smoothstep(style->crown - 1, style->crown + 4, p.y);
    float across = p.x - style->part;
    across +=
        (fmaxf(across * root->side, 0.9f) * root->side - across) * (1 - behind);
    struct vec3 away = vec_unit(vec(across, fmaxf(p.y - style->crown, 0), 0));
    away.y += style->sweep * vec_smoothstep(5, -6, p.y) +
              0.6f * vec_smoothstep(-4, 6, p.y);
    // The face stays free: in front of it the comb only goes sideways.
    float face = vec_smoothstep(-3, -8, p.y) * vec_smoothstep(8, 2, p.z);
    away.x += face * root->side;
    // Where the head turns inwards a level direction would lead upwards.
    float level = vec_smoothstep(-0.1f, 0.6f, n.z);
    return vec_unit(vec_mix(vec(0.3f * away.x, 0.3f * away.y, -1), away,
                            fmaxf(level, 0.7f * face)));
}

// Raises `d` so that it leads away from a surface at least at `rate`.
static struct vec3 slide(struct vec3 d, struct vec3 normal, float rate)
{
    float have = vec_dot(d, normal);
    return have < rate ? vec_mad(d, rate - have, normal) : d;
}

static struct vec3 slide_neck(struct vec3 p, struct vec3 d, float layer)
{
    struct vec3 o = vec_sub(p, neck_centre), r = neck_radius;
    struct vec3 q = vec(o.x / r.x, o.y / r.y, o.z / r.z);
    struct vec3 g = vec(q.x / r.x, q.y / r.y, q.z / r.z);
    float f = vec_length(q), slope = vec_length(g);
    float height = (f - 1) * f / slope;
    if (height > layer + 3)
        return d;
    return slide(d, vec_scale(g, 1 / slope), 0.3f * (0.6f * layer - height));
}

static struct vec3 pull_at(const struct groom_style *style, struct vec3 p,
                           float s)
{
    struct vec3 d = {0, 0, -1};
    if (vec_dot(style->wind, style->wind) > 0) {
        struct vec3 gust = {0, 0, 0};
        for (int k = 0; k < 2; k++) {
            struct vec3 at = vec_scale(p, k == 0 ? 0.07f : 0.17f);
            uint32_t seed = 11 + 3 * (uint32_t)k;
            gust = vec_mad(gust, k == 0 ? 1.0f : 0.6f,
                           vec(groom_builtin_head_noise(at, seed),
                               groom_builtin_head_noise(at, seed + 1),
                               groom_builtin_head_noise(at, seed + 2)));
        }
        float strength = vec_smoothstep(0, 14, s);
        d = vec_mad(d, strength, style->wind);
        d = vec_mad(d, strength * style->gusts, gust);
    }
    if (style->tuck > 0) {
        float low = vec_smoothstep(style->cut + 6, style->cut, p.z);
        struct vec3 in = vec_unit(vec(-p.x, 2 - p.y, 0));
        d = vec_mad(d, style->tuck * low, in);
    }
    return d;
}

// What differs from strand to strand.
struct habit {
    float layer, stiffness, comb_turn;
};

static struct habit habit_of(const struct groom_style *style,
                             const struct groom_root *root)
{
    // Hair of the crown lies on top of the hair below it.
    float deep = vec_random(root->id, STREAM_LAYER);
    float high = 0.2f + 0.8f * vec_smoothstep(-0.6f, 0.6f, root->dir.z);
    struct habit h = {
        .layer = style->layer * high * (0.10f + 0.90f * deep),
        .stiffness = style->stiffness,
        .comb_turn =
            0.30f * groom_builtin_head_noise(vec_scale(root->p, 0.4f), 5) +
            0.12f * vec_signed(root->id, STREAM_STRAY),
    };
    if (root->fringe)
        h.layer *= 0.6f;
    if (root->fly) {
        float far = vec_random(root->id, STREAM_STRAY2);
        h.layer += 0.7f * far * far;
        h.stiffness *= 1.4f;
        h.comb_turn *= 1.3f;
    }
    return h;
}

static struct vec3 first_direction(const struct groom_style *style,
                                   const struct groom_root *root,
                                   struct vec3 normal)
{
    float lift = style->lift * (1 + 0.35f * vec_signed(root->id, STREAM_LIFT)) *
                 (root->fly ? 1.15f : 1);
    struct vec3 comb = comb_at(style, root, root->p, normal);
    comb = vec_unit(vec_mad(comb, -vec_dot(comb, normal), normal));
    return vec_unit(vec_mad(comb, lift, normal));
}

// Below this nothing is left of a strand after the cut, whatever its lock does.
static float lowest_of_use(const struct groom_style *style,
                           const struct groom_root *root)
{
    float cut = root->fringe ? style->cut_fringe : style->cut;
    return cut - style->ragged - 6;
}

// A growing strand: place, direction, what it knows of the head there, and how
// much the comb still holds and the root still keeps it down.
struct tip {
    struct vec3 p, t, normal;
    float height, comb, low;
};

static void advance(const struct groom_style *style,
                    const struct groom_root *root, const struct habit *habit,
                    float s, struct tip *tip)
{
    struct vec3 d = pull_at(style, tip->p, s), n = tip->normal;
    float lie = habit->layer * (1 - tip->low);
    if (tip->height < style->layer + 4) {
        struct vec3 comb = comb_at(style, root, tip->p, n);
        comb = vec_mad(comb, -vec_dot(comb, n), n);
        comb = vec_mad(comb, habit->comb_turn, vec_cross(n, comb));
        float near =
            vec_smoothstep(style->layer + 4, style->layer, tip->height);
        d = vec_unit(vec_mad(d, style->comb * tip->comb * near, comb));
        d = slide(d, n, 0.45f * (lie - tip->height));
    }
    if (tip->p.z < -8)
        d = slide_neck(tip->p, d, habit->layer);
    float turn = style->step / (style->step + habit->stiffness);
    tip->t = vec_unit(vec_mix(tip->t, vec_unit(d), turn));
    tip->p = vec_mad(tip->p, style->step, tip->t);
    tip->height = groom_builtin_head_height(tip->p, &tip->normal);
    float least = 0.05f + 0.15f * lie;
    if (tip->height < least) {
        tip->p = vec_mad(tip->p, least - tip->height, tip->normal);
        tip->height = least;
    }
}

void groom_builtin_grow(const struct groom_style *style,
                        const struct groom_root *root, float length,
                        struct groom_curve *curve)
{
    struct habit habit = habit_of(style, root);
    struct tip tip = {.p = root->p, .comb = 1, .low = 1};
    tip.height = groom_builtin_head_height(tip.p, &tip.normal);
    tip.t = first_direction(style, root, tip.normal);
    float comb_step = expf(-style->step / style->comb_length);
    float low_step = expf(-style->step / 6);
    float end = lowest_of_use(style, root);
    int count = 1 + (int)ceilf(length / style->step);
    if (count > GROOM_CURVE_MAX)
        count = GROOM_CURVE_MAX;
    curve->n = 0;
    curve->step = style->step;
    curve->tie = 0;
    for (int k = 0; k < count && (k < 2 || tip.p.z > end); k++) {
        curve->p[curve->n++] = tip.p;
        advance(style, root, &habit, (float)(k + 1) * style->step, &tip);
        tip.comb *= comb_step;
        tip.low *= low_step;
    }
}
