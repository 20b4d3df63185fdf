// metric.c - errors of radiance at places, with their intervals.  Pictures as
// displayed are metric_picture.c's.
#include "renderer/metric.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"

enum { ROUNDS = 1000 };

struct place { // sums over the three channels
    double square, relative, signed_sum, reference, variance;
};

struct outlier { // of one channel
    double size;
    size_t place;
};

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int by_size_down(const void *a, const void *b)
{
    const struct outlier *x = a, *y = b;
    if (x->size != y->size)
        return x->size < y->size ? 1 : -1;
    return (x->place > y->place) - (x->place < y->place);
}

static size_t rank_of(size_t n, double q)
{
    // 1e-9: q * n that is a whole number but for rounding is that number
    const double r = ceil(q * (double)n - 1e-9) - 1;
    return r < 0 ? 0 : r > (double)(n - 1) ? n - 1 : (size_t)r;
}

static double *sorted_copy(const double *values, size_t n)
{
    double *s = bytes_alloc(n * sizeof *s);
    memcpy(s, values, n * sizeof *s);
    qsort(s, n, sizeof *s, by_value);
    return s;
}

double metric_quantile(const double *values, size_t n, double q)
{
    double *s = sorted_copy(values, n);
    const double found = s[rank_of(n, q)];
    free(s);
    return found;
}

// How many values from either end may be left out: the largest k with
// P(Binomial(n, 1/2) < k) <= 0.025.
static size_t order_margin(size_t n)
{
    double term = pow(0.5, (double)n), below = 0;
    size_t k = 0;
    while (k < n / 2 && below + term <= 0.025) {
        below += term;
        term *= (double)(n - k) / (double)(k + 1);
        k++;
    }
    return k;
}

struct metric_value metric_median(const double *values, size_t n)
{
    double *s = sorted_copy(values, n);
    const size_t k = order_margin(n), cut = k > 0 ? k - 1 : 0;
    const struct metric_value m = {s[rank_of(n, 0.5)], s[cut], s[n - 1 - cut]};
    free(s);
    return m;
}

// --- errors at places --------------------------------------------------------

static void add_place(const struct metric_pairs *p, size_t i, struct place *out,
                      struct outlier *o)
{
    *out = (struct place){0};
    for (size_t c = 3 * i; c < 3 * i + 3; c++) {
        const double d = p->x[c] - p->r[c],
                     v = p->variance ? p->variance[c] : 0;
        const double scale = p->r[c] * p->r[c] + 0.01;
        out->square += d * d - v;
        out->relative += (d * d - v) / scale;
        out->signed_sum += d;
        out->reference += p->r[c];
        out->variance += v;
        o[c] = (struct outlier){fabs(d), i};
    }
}

struct four {
    double rel_rmse, rel_mse, mean_signed, p99;
};

// Errors of the sample in which place i occurs times[i] times; `count` in all.
static struct four of_sample(const struct place *place, const struct outlier *o,
                             const uint32_t *times, size_t count)
{
    struct place sum = {0};
    for (size_t i = 0; i < count; i++) {
        const double n = times[i];
        sum.square += n * place[i].square;
        sum.relative += n * place[i].relative;
        sum.signed_sum += n * place[i].signed_sum;
        sum.reference += n * place[i].reference;
    }
    const double all = 3 * (double)count, mean = sum.reference / all;
    // rank from the top of the value that 99 % do not exceed
    const size_t above = 3 * count - rank_of(3 * count, 0.99);
    size_t seen = 0, at = 0;
    while (at < 3 * count && (seen += times[o[at].place]) < above)
        at++;
    return (struct four){
        .rel_rmse = sqrt(fmax(0, sum.square / all)) / mean,
        .rel_mse = fmax(0, sum.relative / all),
        .mean_signed = sum.signed_sum / all / mean,
        .p99 = o[at < 3 * count ? at : 3 * count - 1].size / mean,
    };
}

static uint64_t next_random(uint64_t *state) // SplitMix64
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static struct metric_value with_interval(double value, const double *rounds)
{
    return (struct metric_value){value, metric_quantile(rounds, ROUNDS, 0.025),
                                 metric_quantile(rounds, ROUNDS, 0.975)};
}

static void bootstrap(const struct place *place, const struct outlier *o,
                      uint32_t *times, size_t count, struct metric_errors *out)
{
    double *rounds = bytes_alloc(4 * ROUNDS * sizeof *rounds);
    uint64_t state = 1;
    for (size_t i = 0; i < count; i++)
        times[i] = 1;
    const struct four whole = of_sample(place, o, times, count);
    for (size_t k = 0; k < ROUNDS; k++) {
        memset(times, 0, count * sizeof *times);
        for (size_t i = 0; i < count; i++)
            times[next_random(&state) % count]++;
        const struct four f = of_sample(place, o, times, count);
        rounds[k] = f.rel_rmse;
        rounds[ROUNDS + k] = f.rel_mse;
        rounds[2 * ROUNDS + k] = f.mean_signed;
        rounds[3 * ROUNDS + k] = f.p99;
    }
    out->rel_rmse = with_interval(whole.rel_rmse, rounds);
    out->rel_mse = with_interval(whole.rel_mse, rounds + ROUNDS);
    out->mean_signed = with_interval(whole.mean_signed, rounds + 2 * ROUNDS);
    out->p99 = with_interval(whole.p99, rounds + 3 * ROUNDS);
    free(rounds);
}

void metric_errors(const struct metric_pairs *p, struct metric_errors *out)
{
    const struct metric_value none = {NAN, NAN, NAN};
    *out = (struct metric_errors){none, none, none, none, NAN, NAN};
    if (p->count == 0)
        return;
    struct place *place = bytes_alloc(p->count * sizeof *place);
    struct outlier *o = bytes_alloc(3 * p->count * sizeof *o);
    uint32_t *times = bytes_alloc(p->count * sizeof *times);
    double reference = 0, variance = 0;
    for (size_t i = 0; i < p->count; i++) {
        add_place(p, i, &place[i], o);
        reference += place[i].reference;
        variance += place[i].variance;
    }
    qsort(o, 3 * p->count, sizeof *o, by_size_down);
    const double all = 3 * (double)p->count;
    out->mean = reference / all;
    if (reference > 0) {
        out->noise = sqrt(variance / all) / out->mean;
        bootstrap(place, o, times, p->count, out);
    }
    free(place);
    free(o);
    free(times);
}
