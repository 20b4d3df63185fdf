// groom_vec.h - three floats at a time, and numbers that look random.
// Thread: any (no state).
#ifndef RENDERER_GROOM_VEC_H
#define RENDERER_GROOM_VEC_H

#include <math.h>
#include <stdint.h>

struct vec3 {
    float x, y, z;
};

static inline struct vec3 vec(float x, float y, float z)
{
    return (struct vec3){x, y, z};
}

static inline struct vec3 vec_add(struct vec3 a, struct vec3 b)
{
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline struct vec3 vec_sub(struct vec3 a, struct vec3 b)
{
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline struct vec3 vec_scale(struct vec3 a, float k)
{
    return vec(a.x * k, a.y * k, a.z * k);
}

// a + k b
static inline struct vec3 vec_mad(struct vec3 a, float k, struct vec3 b)
{
    return vec(a.x + k * b.x, a.y + k * b.y, a.z + k * b.z);
}

static inline struct vec3 vec_mix(struct vec3 a, struct vec3 b, float t)
{
    return vec_mad(a, t, vec_sub(b, a));
}

static inline float vec_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec3 vec_cross(struct vec3 a, struct vec3 b)
{
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
               a.x * b.y - a.y * b.x);
}

static inline float vec_length(struct vec3 a)
{
    return sqrtf(vec_dot(a, a));
}

// The zero vector stays (almost) zero.
static inline struct vec3 vec_unit(struct vec3 a)
{
    return vec_scale(a, 1 / sqrtf(vec_dot(a, a) + 1e-20f));
}

static inline float vec_clamp(float x, float low, float high)
{
    return x < low ? low : x > high ? high : x;
}

static inline float vec_smoothstep(float a, float b, float x)
{
    float t = vec_clamp((x - a) / (b - a), 0, 1);
    return t * t * (3 - 2 * t);
}

// An integer mixed until no bit of it shows.
static inline uint32_t vec_hash(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

// Uniform in [0, 1): one number per item and stream.
static inline float vec_random(uint32_t item, uint32_t stream)
{
    uint32_t h = vec_hash(item + vec_hash(stream * 0x9e3779b9u + 1));
    return (float)(h >> 8) * 0x1p-24f;
}

// Uniform in [-1, 1).
static inline float vec_signed(uint32_t item, uint32_t stream)
{
    return 2 * vec_random(item, stream) - 1;
}

#endif
