// metric_picture.c - pictures as displayed: the curve, PSNR, SSIM.
#include "renderer/metric.h"

#include <math.h>
#include <stdlib.h>

#include "protocol/bytes.h"

enum { WINDOW = 11 };

static double srgb(double v)
{
    if (v <= 0.0031308)
        return 12.92 * fmax(0, v);
    return fmin(1, 1.055 * pow(v, 1 / 2.4) - 0.055);
}

void metric_display(const float *rgba, size_t pixels, const float colour[3],
                    double stops, uint8_t *out)
{
    const double gain = exp2(stops);
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++) {
            const double clear = 1 - (double)rgba[4 * i + 3];
            const double v =
                (double)rgba[4 * i + c] + clear * (double)colour[c];
            out[3 * i + c] = (uint8_t)lrint(255 * srgb(gain * v));
        }
}

double metric_psnr(const uint8_t *a, const uint8_t *b, size_t values)
{
    double sum = 0;
    for (size_t i = 0; i < values; i++) {
        const double d = (double)a[i] - (double)b[i];
        sum += d * d;
    }
    return 10 * log10(255.0 * 255.0 * (double)values / sum);
}

static void weights(double w[WINDOW])
{
    double sum = 0;
    for (int i = 0; i < WINDOW; i++) {
        const double x = i - WINDOW / 2;
        sum += w[i] = exp(-x * x / (2 * 1.5 * 1.5));
    }
    for (int i = 0; i < WINDOW; i++)
        w[i] /= sum;
}

static double luma(const uint8_t *rgb)
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// The window is a product, so rows are summed first, then columns.  Five
// moments a pixel: x, y, xx, yy, xy.
enum { MOMENTS = 5 };

static void sum_row(const uint8_t *a, const uint8_t *b, int width,
                    const double w[WINDOW], double *out)
{
    for (int x = 0; x + WINDOW <= width; x++) {
        double *m = out + MOMENTS * x;
        for (int k = 0; k < MOMENTS; k++)
            m[k] = 0;
        for (int i = 0; i < WINDOW; i++) {
            const double u = luma(a + 3 * (x + i)), v = luma(b + 3 * (x + i));
            m[0] += w[i] * u;
            m[1] += w[i] * v;
            m[2] += w[i] * u * u;
            m[3] += w[i] * v * v;
            m[4] += w[i] * u * v;
        }
    }
}

// Wang 2004, eq 13.
static double similarity(const double m[MOMENTS])
{
    const double c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255;
    const double xx = m[2] - m[0] * m[0], yy = m[3] - m[1] * m[1];
    const double xy = m[4] - m[0] * m[1];
    return (2 * m[0] * m[1] + c1) * (2 * xy + c2) /
           ((m[0] * m[0] + m[1] * m[1] + c1) * (xx + yy + c2));
}

double metric_ssim(const uint8_t *a, const uint8_t *b, int width, int height)
{
    if (width < WINDOW || height < WINDOW)
        return NAN;
    const int columns = width - WINDOW + 1, rows = height - WINDOW + 1;
    const size_t stride = MOMENTS * (size_t)columns;
    double *line = bytes_alloc(stride * (size_t)height * sizeof *line);
    double w[WINDOW], sum = 0;
    weights(w);
    for (size_t y = 0; y < (size_t)height; y++)
        sum_row(a + 3 * (size_t)width * y, b + 3 * (size_t)width * y, width, w,
                line + stride * y);
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            double m[MOMENTS] = {0};
            for (int i = 0; i < WINDOW; i++)
                for (int k = 0; k < MOMENTS; k++)
                    m[k] += w[i] * line[stride * (size_t)(y + i) +
                                        (size_t)(MOMENTS * x + k)];
            sum += similarity(m);
        }
    free(line);
    return sum / ((double)columns * rows);
}
