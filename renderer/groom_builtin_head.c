// groom_builtin_head.c - the head that the built-in grooms grow on: an
// ellipsoid of an adult's measures, the hairline on it, evenly spread roots,
// and the rule that no hair enters it.
#include "renderer/groom_builtin.h"

// Breadth 15.2, length 19.5, height from chin to vertex 22.4.
const struct vec3 groom_builtin_head_radius = {7.6f, 9.75f, 11.2f};

// Roots stand this far (in units of the radii) above the surface, so that
// rounding never puts one inside.
static const float root_level = 1.001f;
static const float clear_level = 1.0005f;

static struct vec3 to_sphere(struct vec3 p)
{
    return vec(p.x / groom_builtin_head_radius.x,
               p.y / groom_builtin_head_radius.y,
               p.z / groom_builtin_head_radius.z);
}

float groom_builtin_head_height(struct vec3 p, struct vec3 *normal)
{
    struct vec3 q = to_sphere(p), g = to_sphere(q);
    float f = vec_length(q), slope = vec_length(g);
    *normal = vec_scale(g, 1 / slope);
    return (f - 1) * f / slope;
}

static float lattice(int x, int y, int z, uint32_t seed)
{
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^
                 (uint32_t)z * 0xcb1ab31fu ^ seed;
    return (float)(vec_hash(h) >> 8) * 0x1p-23f - 1;
}

static float smooth(float t)
{
    return t * t * (3 - 2 * t);
}

float groom_builtin_head_noise(struct vec3 p, uint32_t seed)
{
    float fx = floorf(p.x), fy = floorf(p.y), fz = floorf(p.z);
    int x = (int)fx, y = (int)fy, z = (int)fz;
    float tx = smooth(p.x - fx), ty = smooth(p.y - fy), tz = smooth(p.z - fz);
    float plane[2];
    for (int k = 0; k < 2; k++) {
        float a = lattice(x, y, z + k, seed),
              b = lattice(x + 1, y, z + k, seed);
        float c = lattice(x, y + 1, z + k, seed);
        float d = lattice(x + 1, y + 1, z + k, seed);
        a += (b - a) * tx;
        c += (d - c) * tx;
        plane[k] = a + (c - a) * ty;
    }
    return plane[0] + (plane[1] - plane[0]) * tz;
}

// The hairline: lowest z of the unit sphere at which hair grows, by angle from
// the face.  Forehead, temples, sideburns, over the ears, nape.
static const float hairline[][2] = {
    {0, 0.62f},    {14, 0.63f},   {30, 0.63f},   {45, 0.58f},   {56, 0.44f},
    {66, 0.24f},   {74, 0.00f},   {79, -0.15f},  {86, -0.14f},  {92, -0.03f},
    {99, 0.02f},   {108, -0.01f}, {117, -0.18f}, {128, -0.38f}, {145, -0.52f},
    {165, -0.55f}, {181, -0.54f}};

static float hairline_at(float degrees)
{
    int i = 1;
    while (hairline[i][0] < degrees)
        i++;
    float t =
        (degrees - hairline[i - 1][0]) / (hairline[i][0] - hairline[i - 1][0]);
    return hairline[i - 1][1] +
           (hairline[i][1] - hairline[i - 1][1]) * smooth(t);
}

static float angle_of(struct vec3 dir)
{
    return fabsf(atan2f(dir.x, -dir.y)) * 57.29578f;
}

bool groom_builtin_head_scalp(struct vec3 dir, uint32_t id)
{
    float line = hairline_at(angle_of(dir)) +
                 0.025f * groom_builtin_head_noise(vec_scale(dir, 9), 77);
    // Hair thins out over the last few millimetres instead of stopping.
    return dir.z > line + 0.05f * vec_random(id, STREAM_HAIRLINE) - 0.02f;
}

// Point `i` of the two-dimensional sequence of Roberts' generalised golden
// ratio; any beginning of it is even.
static struct vec3 sphere_point(uint32_t i)
{
    const uint32_t a = 3242174889u, b = 2447445414u; // 2^32 / g, 2^32 / g^2
    float z = 2 * ((float)((i * a) >> 8) * 0x1p-24f) - 1;
    float phi = 6.2831853f * ((float)((i * b) >> 8) * 0x1p-24f);
    float r = sqrtf(1 - z * z);
    return vec(r * cosf(phi), r * sinf(phi), z);
}

// How much of the ellipsoid's area a piece of the sphere becomes, over the
// most it can be: |n / radius| over 1 / the smallest radius.
static float area_share(struct vec3 dir)
{
    return vec_length(to_sphere(dir)) * groom_builtin_head_radius.x;
}

// Hair stands closer along the hairline and the parting, where it covers least.
static float crowding(const struct groom_style *style, struct vec3 dir)
{
    float above = dir.z - hairline_at(angle_of(dir));
    float sparse = vec_smoothstep(0, 0.2f, above);
    if (!style->tail) {
        struct vec3 r = groom_builtin_head_radius;
        float x = dir.x * r.x - style->part;
        float y = fmaxf(0, dir.y * r.y - style->crown);
        float far = vec_smoothstep(0.3f, 2.2f, sqrtf(x * x + y * y));
        sparse *= dir.z > 0 ? far : 1;
    }
    return 1 - 0.6f * sparse;
}

static bool in_fringe(const struct groom_style *style, struct vec3 dir,
                      uint32_t id)
{
    if (style->tail) { // at the temples, where strands come loose
        float above = dir.z - hairline_at(angle_of(dir));
        return fabsf(angle_of(dir) - 57) < 5 && above < style->fringe;
    }
    // A wedge from the crown to the forehead.
    float along = (-dir.y - 0.12f) / 0.6f;
    float x = fabsf(dir.x) * groom_builtin_head_radius.x +
              0.5f * vec_signed(id, STREAM_STRAY2);
    return style->fringe > 0 && along > 0 &&
           x < style->fringe * fminf(1, 0.25f + along);
}

struct groom_root groom_builtin_head_root(const struct groom_style *style,
                                          uint32_t id, uint32_t *cursor)
{
    for (;;) {
        uint32_t i = ++*cursor;
        struct vec3 dir = sphere_point(i);
        if (vec_random(i, STREAM_ACCEPT) >
                area_share(dir) * crowding(style, dir) ||
            !groom_builtin_head_scalp(dir, i))
            continue;
        struct groom_root root = {.id = id, .dir = dir};
        root.p = vec(dir.x * groom_builtin_head_radius.x * root_level,
                     dir.y * groom_builtin_head_radius.y * root_level,
                     dir.z * groom_builtin_head_radius.z * root_level);
        float edge = style->part +
                     0.12f * groom_builtin_head_noise(root.p, 901) +
                     0.10f * vec_signed(id, STREAM_COMB);
        root.side = root.p.x < edge ? -1 : 1;
        root.fringe = in_fringe(style, dir, id);
        root.fly = vec_random(id, STREAM_FLY) < style->flyaways;
        return root;
    }
}

// Smallest |q| on the segment, in the space where the head is a unit sphere.
static float lowest(struct vec3 a, struct vec3 b)
{
    struct vec3 d = vec_sub(b, a);
    float t = -vec_dot(a, d) / (vec_dot(d, d) + 1e-20f);
    return vec_length(vec_mad(a, vec_clamp(t, 0, 1), d));
}

void groom_builtin_head_keep_out(float *position, uint32_t n)
{
    struct vec3 a = to_sphere(vec(position[0], position[1], position[2]));
    for (uint32_t i = 1; i < n; i++) {
        float *p = position + 3 * (size_t)i;
        struct vec3 b = to_sphere(vec(p[0], p[1], p[2]));
        bool moved = false;
        // A long segment that leaves its root along the surface has to be
        // raised in a few goes; the last one raises it for certain.
        for (int go = 0; go < 40; go++) {
            float low = lowest(a, b);
            if (low >= clear_level)
                break;
            b = vec_scale(b, fmaxf(clear_level / fmaxf(low, 0.1f), 1.002f));
            moved = true;
        }
        if (moved) {
            p[0] = b.x * groom_builtin_head_radius.x;
            p[1] = b.y * groom_builtin_head_radius.y;
            p[2] = b.z * groom_builtin_head_radius.z;
        }
        a = b;
    }
}
