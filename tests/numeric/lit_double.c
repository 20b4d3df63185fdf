// lit_double.c - see the header.
#include "tests/numeric/lit_double.h"

#include <math.h>
#include <stddef.h>

enum { CHANNELS = LIT_DOUBLE_CHANNELS, HERE = 1, PHI = 2 };
// Half a step of bfloat16, of a byte; what a float's place in a table may be
// off, in cells.
static const double half_float = 1.0 / 256, half_byte = 1.0 / 127,
                    off_place = 4e-5;
static const double byte_most = 2, steep_most = 8;

// First and second differences of one channel.
struct quadratic {
    double v, s, d, p, ss, dd, pp, sd, sp, dp;
};

static double at(const struct lit_double_values *v, const int i[3], int c)
{
    return v->at[HERE + i[0]][HERE + i[1]][PHI + i[2]][c];
}

#define AT(s, d, p) at(v, (const int[3]){s, d, p}, c)

// What both kinds of table have.  At an end of theta_o the mixed differences
// span one cell, and are taken as if it were two: passes do the same, and twice
// as much was measured to be no nearer to the truth.
static struct quadratic common(const struct lit_double_values *v, int c,
                               bool edge)
{
    struct quadratic q = {.v = AT(0, 0, 0)};
    q.s = (AT(1, 0, 0) - AT(-1, 0, 0)) / 2;
    q.d = (AT(0, 1, 0) - AT(0, -1, 0)) / (edge ? 1 : 2);
    q.ss = (AT(1, 0, 0) + AT(-1, 0, 0)) / 2 - q.v;
    q.dd = edge ? 0 : (AT(0, 1, 0) + AT(0, -1, 0)) / 2 - q.v;
    q.sd = (AT(1, 1, 0) - AT(1, -1, 0) - AT(-1, 1, 0) + AT(-1, -1, 0)) / 4;
    return q;
}

static struct quadratic near_of(const struct lit_double_values *v, int c,
                                const struct lit_double_at *a)
{
    struct quadratic q = common(v, c, a->edge);
    if (a->phi < a->phis - 1) {
        q.p = (AT(0, 0, 1) - AT(0, 0, -1)) / 2;
        q.pp = (AT(0, 0, 1) + AT(0, 0, -1)) / 2 - q.v;
        q.sp = (AT(1, 0, 1) - AT(1, 0, -1) - AT(-1, 0, 1) + AT(-1, 0, -1)) / 4;
        q.dp = (AT(0, 1, 1) - AT(0, 1, -1) - AT(0, -1, 1) + AT(0, -1, -1)) / 4;
        return q;
    }
    q.p = (3 * q.v - 4 * AT(0, 0, -1) + AT(0, 0, -2)) / 2;
    q.pp = (q.v - 2 * AT(0, 0, -1) + AT(0, 0, -2)) / 2;
    q.sp = (AT(1, 0, 0) - AT(1, 0, -1) - AT(-1, 0, 0) + AT(-1, 0, -1)) / 2;
    q.dp = (AT(0, 1, 0) - AT(0, 1, -1) - AT(0, -1, 0) + AT(0, -1, -1)) / 2;
    return q;
}

// Parabolas through three of Phi at both ends.
static struct quadratic far_of(const struct lit_double_values *v, int c,
                               const struct lit_double_at *a)
{
    struct quadratic q = common(v, c, a->edge);
    const int m = a->phi == 0 ? 1 : a->phi == a->phis - 1 ? -1 : 0;
    const double bend = AT(0, 0, m - 1) - 2 * AT(0, 0, m) + AT(0, 0, m + 1);
    q.p = (AT(0, 0, m + 1) - AT(0, 0, m - 1)) / 2 - m * bend;
    q.pp = bend / 2;
    q.sp = (AT(1, 0, m + 1) - AT(1, 0, m - 1) - AT(-1, 0, m + 1) +
            AT(-1, 0, m - 1)) /
           4;
    q.dp = (AT(0, 1, m + 1) - AT(0, 1, m - 1) - AT(0, -1, m + 1) +
            AT(0, -1, m - 1)) /
           4;
    return q;
}

// The channels' second derivatives are those of their sum, in its units.
static void share(struct quadratic q[CHANNELS])
{
    struct quadratic a = q[0];
    for (int c = 1; c < CHANNELS; c++) {
        a.v += q[c].v;
        a.ss += q[c].ss;
        a.dd += q[c].dd;
        a.pp += q[c].pp;
        a.sd += q[c].sd;
        a.sp += q[c].sp;
        a.dp += q[c].dp;
    }
    const double per = 1 / fmax(a.v, 1e-20);
    for (int c = 0; c < CHANNELS; c++) {
        q[c].ss = a.ss * per;
        q[c].dd = a.dd * per;
        q[c].pp = a.pp * per;
        q[c].sd = a.sd * per;
        q[c].sp = a.sp * per;
        q[c].dp = a.dp * per;
    }
}

// Limits *v; true when that changed it, by a byte's rounding or more.
static bool limit(double *v, double most)
{
    const bool full = fabs(*v) > most - half_byte;
    *v = fmin(fmax(*v, -most), most);
    return full;
}

static bool limit_bends(struct quadratic *q)
{
    bool full = limit(&q->ss, steep_most);
    full |= limit(&q->dd, byte_most);
    full |= limit(&q->pp, byte_most);
    full |= limit(&q->sd, byte_most);
    full |= limit(&q->sp, byte_most);
    return limit(&q->dp, byte_most) || full;
}

static double second(const struct quadratic *q, const double x[3])
{
    return q->ss * x[0] * x[0] + q->dd * x[1] * x[1] + q->pp * x[2] * x[2] +
           q->sd * x[0] * x[1] + q->sp * x[0] * x[2] + q->dp * x[1] * x[2];
}

// By how much the bends' bits can move `second`.
static double second_packing(const struct quadratic *q, const double x[3])
{
    return half_float * fabs(q->ss) * x[0] * x[0] +
           half_byte * (x[1] * x[1] + x[2] * x[2] + fabs(x[0] * x[1]) +
                        fabs(x[0] * x[2]) + fabs(x[1] * x[2]));
}

struct lit_double_result lit_double_near(const struct lit_double_values *v,
                                         const struct lit_double_at *a)
{
    struct lit_double_result r = {.full = false};
    struct quadratic q[CHANNELS];
    for (int c = 0; c < CHANNELS; c++)
        q[c] = near_of(v, c, a);
    share(q);
    for (int c = 0; c < CHANNELS; c++) {
        const double *x = a->x;
        r.full |= limit_bends(&q[c]);
        const double flat = 1 + second(&q[c], x);
        const double line[3] = {q[c].s * x[0], q[c].d * x[1], q[c].p * x[2]};
        r.value[c] = fmax(q[c].v * flat + line[0] + line[1] + line[2], 0);
        r.packing[c] =
            half_float * (fabs(q[c].v * flat) + fabs(line[0]) + fabs(line[1]) +
                          fabs(line[2])) +
            q[c].v * second_packing(&q[c], x) +
            off_place * (fabs(q[c].s) + fabs(q[c].d) + fabs(q[c].p) + q[c].v);
    }
    return r;
}

// What changes with ln sigma_f: sy, dy, py and yy of the channels' sum.
struct widening {
    double y[CHANNELS], sy, dy, py, yy;
};

static struct widening widening_of(const struct lit_double_values all[3],
                                   const struct lit_double_at *a)
{
    struct widening w = {.sy = 0};
    const int m = a->phi == 0 ? 1 : a->phi == a->phis - 1 ? -1 : 0;
    double total = 0;
    for (int c = 0; c < CHANNELS; c++) {
        double s[3], d[3], p[3], here[3];
        for (int k = 0; k < 3; k++) {
            const struct lit_double_values *v = &all[k];
            s[k] = AT(1, 0, 0) - AT(-1, 0, 0);
            d[k] = AT(0, 1, 0) - AT(0, -1, 0);
            p[k] = AT(0, 0, m + 1) - AT(0, 0, m - 1);
            here[k] = AT(0, 0, 0);
        }
        w.y[c] = (here[2] - here[0]) / 2 / fmax(here[1], 1e-20);
        w.sy += (s[2] - s[0]) / 4;
        w.dy += (d[2] - d[0]) / 4;
        w.py += (p[2] - p[0]) / 4;
        w.yy += (here[2] + here[0]) / 2 - here[1];
        total += here[1];
    }
    const double per = 1 / fmax(total, 1e-20);
    w.sy *= per;
    w.dy *= per;
    w.py *= per;
    w.yy *= per;
    return w;
}

struct lit_double_result lit_double_far(const struct lit_double_values all[3],
                                        const struct lit_double_at *a,
                                        const double width[CHANNELS])
{
    struct lit_double_result r = {.full = false};
    struct quadratic q[CHANNELS];
    struct widening w = widening_of(all, a);
    const double *x = a->x;
    for (int c = 0; c < CHANNELS; c++)
        q[c] = far_of(&all[1], c, a);
    share(q);
    r.full |= limit(&w.sy, byte_most);
    r.full |= limit(&w.dy, byte_most);
    r.full |= limit(&w.py, byte_most);
    r.full |= limit(&w.yy, byte_most);
    for (int c = 0; c < CHANNELS; c++) {
        const double y = fmin(fmax(width[c], -2), 2);
        double slope[4] = {q[c].s, q[c].d, q[c].p, 0}, sum = 0, loose = 0;
        for (int k = 0; k < 3; k++)
            slope[k] /= fmax(q[c].v, 1e-20);
        slope[3] = w.y[c];
        for (int k = 0; k < 4; k++) {
            r.full |= limit(&slope[k], byte_most);
            sum += slope[k] * (k < 3 ? x[k] : y);
            loose += half_byte * fabs(k < 3 ? x[k] : y);
        }
        r.full |= limit_bends(&q[c]);
        sum += 1 + second(&q[c], x) +
               y * (w.sy * x[0] + w.dy * x[1] + w.py * x[2] + w.yy * y);
        loose += second_packing(&q[c], x) +
                 half_byte * fabs(y) *
                     (fabs(x[0]) + fabs(x[1]) + fabs(x[2]) + fabs(y));
        r.value[c] = q[c].v * fmax(sum, 0);
        r.packing[c] =
            q[c].v * (half_float * fmax(sum, 0) + loose +
                      off_place * (fabs(slope[0]) + fabs(slope[1]) +
                                   fabs(slope[2]) + fabs(slope[3]) + 1));
    }
    return r;
}
