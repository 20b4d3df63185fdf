// Errors, their intervals, quantiles, PSNR and SSIM against values found by
// other ways: by hand, by the formula written out plainly, by counting how
// often an interval holds the truth.
#include "renderer/metric.h"

#include <stdlib.h>

#include "tests/check.h"

static uint64_t state = 7;
static double uniform(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

static double normal(void) // Box-Muller
{
    const double u = 1 - uniform(), v = uniform();
    return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}

static void by_hand(void)
{
    // squares 0.01 0.04 0 0.25 0 0.01, mean r = 1
    const double x[] = {1.1, 0.8, 1, 2.5, 0.5, 0.4};
    const double r[] = {1, 1, 1, 2, 0.5, 0.5};
    const double v[] = {0.001, 0.002, 0, 0.003, 0, 0.006};
    struct metric_errors e;
    const struct metric_pairs p = {2, x, r, NULL};
    check_case("errors of two places by hand");
    metric_errors(&p, &e);
    CHECK_NEAR(e.rel_rmse.value, sqrt(0.31 / 6), 1e-14);
    CHECK_NEAR(e.rel_mse.value, (0.05 / 1.01 + 0.25 / 4.01 + 0.01 / 0.26) / 6,
               1e-14);
    CHECK_NEAR(e.mean_signed.value, (0.1 - 0.2 + 0.5 - 0.1) / 6, 1e-14);
    CHECK_NEAR(e.p99.value, 0.5, 1e-14);
    CHECK_NEAR(e.noise, 0, 0);
    const struct metric_pairs noisy = {2, x, r, v};
    check_case("the reference's variance is taken off");
    metric_errors(&noisy, &e);
    CHECK_NEAR(e.rel_rmse.value, sqrt((0.31 - 0.012) / 6), 1e-14);
    CHECK_NEAR(e.noise, sqrt(0.012 / 6), 1e-14);
    check_case("equal is zero; no place and a black reference are NaN");
    metric_errors(&(struct metric_pairs){2, r, r, NULL}, &e);
    CHECK(e.rel_rmse.value == 0 && e.rel_mse.high == 0 && e.p99.value == 0);
    metric_errors(&(struct metric_pairs){0, x, r, NULL}, &e);
    CHECK(isnan(e.rel_rmse.value) && isnan(e.p99.high));
    const double black[6] = {0};
    metric_errors(&(struct metric_pairs){2, x, black, NULL}, &e);
    CHECK(isnan(e.rel_rmse.value));
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// A known error under a known noise: x = r + 0.2 n, r seen through noise 0.3.
enum { PLACES = 400, TRIALS = 60 };
static void trial(struct metric_errors *e, double *p99)
{
    static double x[3 * PLACES], r[3 * PLACES], v[3 * PLACES], d[3 * PLACES];
    double mean = 0;
    for (size_t c = 0; c < 3 * PLACES; c++) {
        const double truth = 1 + uniform();
        x[c] = truth + 0.2 * normal();
        r[c] = truth + 0.3 * normal();
        v[c] = 0.09;
        d[c] = fabs(x[c] - r[c]);
        mean += r[c] / (3 * PLACES);
    }
    metric_errors(&(struct metric_pairs){PLACES, x, r, v}, e);
    qsort(d, 3 * PLACES, sizeof *d, compare);
    *p99 = d[1187] / mean; // the 1188th of 1200 is the first that 99 % reach
}

static void intervals(void)
{
    int holds = 0, holds_signed = 0;
    double mean = 0, p99 = 0;
    struct metric_errors e;
    check_case("intervals hold the truth about as often as they say");
    for (int k = 0; k < TRIALS; k++) {
        trial(&e, &p99);
        const double truth = 0.2 / 1.5;
        mean += e.rel_rmse.value / TRIALS;
        holds += e.rel_rmse.low <= truth && truth <= e.rel_rmse.high;
        holds_signed += e.mean_signed.low <= 0 && 0 <= e.mean_signed.high;
        CHECK(e.rel_rmse.low < e.rel_rmse.value);
        CHECK(e.rel_rmse.value < e.rel_rmse.high);
    }
    CHECK_NEAR(e.p99.value, p99, 1e-14);
    // 60 draws of 95 %: 52 or fewer happen once in 100 runs of other seeds
    CHECK(holds >= 52 && holds_signed >= 52);
    // each trial's own deviation is 0.009, so of their mean 0.0012; 4 x that
    CHECK_ATMOST(fabs(mean - 0.2 / 1.5), 0.005);
}

static void quantiles(void)
{
    const double v[] = {5, 1, 4, 2, 3, 10, 9, 8, 7, 6};
    check_case("quantiles by nearest rank");
    CHECK(metric_quantile(v, 10, 0.5) == 5);
    CHECK(metric_quantile(v, 10, 0.95) == 10);
    CHECK(metric_quantile(v, 10, 0.9) == 9);
    CHECK(metric_quantile(v, 10, 0) == 1);
    CHECK(metric_quantile(v, 1, 0.95) == 5);
    // Binomial(10, 1/2): P(0) + P(1) = 11/1024 < .025 < P(0..2) = 56/1024
    const struct metric_value m = metric_median(v, 10);
    check_case("a median's interval by order statistics");
    CHECK(m.value == 5 && m.low == 2 && m.high == 9);
    // 20: P(0..5) = .0207, P(0..6) = .058: the 6th and the 15th
    double w[20];
    for (int i = 0; i < 20; i++)
        w[i] = 20 - i;
    CHECK(metric_median(w, 20).low == 6 && metric_median(w, 20).high == 15);
    CHECK(metric_median(v, 3).low == 1 && metric_median(v, 3).high == 5);
}

// --- pictures ----------------------------------------------------------------
enum { WIDE = 23, HIGH = 17 };
static uint8_t one[3 * WIDE * HIGH], two[3 * WIDE * HIGH];

static void make_pictures(void)
{
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++)
            for (int c = 0; c < 3; c++) {
                const int at = 3 * (y * WIDE + x) + c;
                one[at] = (uint8_t)(127 + 100 * sin(0.7 * x + 0.3 * y + c));
                two[at] = (uint8_t)(120 + 90 * sin(0.7 * x + 0.35 * y + c) +
                                    10 * uniform());
            }
}

static double grey(const uint8_t *p, int x, int y)
{
    const uint8_t *at = p + 3 * (y * WIDE + x);
    return 0.2126 * at[0] + 0.7152 * at[1] + 0.0722 * at[2];
}

// One window, centred moments, as the formula is printed.
static double window(int x0, int y0)
{
    double norm = 0, mx = 0, my = 0, sxx = 0, syy = 0, sxy = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int j = -5; j <= 5; j++)
            for (int i = -5; i <= 5; i++) {
                const double w = exp(-(i * i + j * j) / 4.5);
                const double u = grey(one, x0 + i, y0 + j);
                const double v = grey(two, x0 + i, y0 + j);
                if (pass == 0) {
                    norm += w;
                    mx += w * u;
                    my += w * v;
                } else {
                    sxx += w / norm * (u - mx / norm) * (u - mx / norm);
                    syy += w / norm * (v - my / norm) * (v - my / norm);
                    sxy += w / norm * (u - mx / norm) * (v - my / norm);
                }
            }
    mx /= norm;
    my /= norm;
    return (2 * mx * my + 6.5025) * (2 * sxy + 58.5225) /
           ((mx * mx + my * my + 6.5025) * (sxx + syy + 58.5225));
}

static void pictures(void)
{
    make_pictures();
    check_case("psnr: one level everywhere, one value in many, equal");
    uint8_t a[300], b[300];
    for (int i = 0; i < 300; i++) {
        a[i] = (uint8_t)i / 2;
        b[i] = (uint8_t)(a[i] + 1);
    }
    CHECK_NEAR(metric_psnr(a, b, 300), 48.13080361, 1e-8);
    memcpy(b, a, 300);
    CHECK(isinf(metric_psnr(a, b, 300)));
    b[7] = (uint8_t)(a[7] + 30);
    CHECK_NEAR(metric_psnr(a, b, 300), 20 * log10(255. / 30) + 10 * log10(300),
               1e-12);
    check_case("ssim against the formula written out");
    double sum = 0;
    for (int y = 5; y < HIGH - 5; y++)
        for (int x = 5; x < WIDE - 5; x++)
            sum += window(x, y) / ((WIDE - 10) * (HIGH - 10));
    CHECK(sum > 0.5 && sum < 0.99); // the two differ, and are alike
    // rounding: moments up to 65025 subtracted to a variance of 58 and more
    CHECK_NEAR(metric_ssim(one, two, WIDE, HIGH), sum, 1e-10);
    CHECK_NEAR(metric_ssim(one, one, WIDE, HIGH), 1, 1e-12);
    check_case("ssim of two even greys is the first factor alone");
    memset(one, 100, sizeof one);
    memset(two, 150, sizeof two);
    CHECK_NEAR(metric_ssim(one, two, WIDE, HIGH),
               (2 * 100 * 150 + 6.5025) / (100 * 100 + 150 * 150 + 6.5025),
               1e-10);
    CHECK(isnan(metric_ssim(one, two, 10, 17)));
}

static void display(void)
{
    // sRGB of 0.5 is 187.5160.., of 0.2140 is 127.5; 0.002 is linear: 6.589
    const float rgba[] = {0.5f, 0, 0.002f, 1, 0.25f, 2, 0.1f, 0.5f};
    const float colour[] = {0.5f, 0.25f, 0};
    uint8_t out[6];
    check_case("display: over the background, by the sRGB curve");
    metric_display(rgba, 2, colour, 0, out);
    CHECK(out[0] == 188 && out[1] == 0 && out[2] == 7);
    CHECK(out[3] == 188 && out[4] == 255 && out[5] == 89);
    metric_display(rgba, 1, colour, -1, out); // 0.25: 136.96
    CHECK(out[0] == 137);
}

int main(void)
{
    by_hand();
    intervals();
    quantiles();
    pictures();
    display();
    return check_end();
}
