// xu_tables.c - makes the tables by Gauss-Legendre quadrature in double
// precision and hands them to the GPU as 32-bit floats: the terms of eq 13
// alternate in sign and cancel to a hundredth, which half floats would not
// survive.  What is done with the entries is the shader's business.
#include "renderer/xu_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/quadrature.h"

static const double pi = 3.14159265358979323846;

enum { NODES = 32, POWERS = 6 };

struct rule { // on [-1, 1]
    double x[NODES], w[NODES];
};

// --- C_k --------------------------------------------------------------------
// One lambda'.  A narrow light sees a window of x, whose nodes serve every Phi
// but those that have the fold of |cos| inside; a broad one is integrated over
// y = Phi - x, which keeps the fold at the ends.
struct column {
    const struct rule *rule;
    double kappa, window; // 2 / lambda'^2; half width in x
    double weight[2 * NODES], cos_half[2 * NODES], sin_half[2 * NODES];
};

#define BROAD 0.4 // lambda' whose light is e^-25 where it is darkest

static double light(double kappa, double sin_half)
{
    return exp(-2 * kappa * sin_half * sin_half);
}

// Two panels side by side between a and b.
static void place_nodes(struct column *c, double a, double b)
{
    for (int i = 0; i < 2 * NODES; i++) {
        double mid = i < NODES ? (3 * a + b) / 4 : (a + 3 * b) / 4;
        double x = mid + (b - a) / 4 * c->rule->x[i % NODES];
        c->cos_half[i] = cos(x / 2);
        c->sin_half[i] = sin(x / 2);
        c->weight[i] = c->rule->w[i % NODES] * (b - a) / 4;
    }
}

static void start_column(struct column *c, const struct rule *rule,
                         double lambda)
{
    c->rule = rule;
    c->kappa = 2 / (lambda * lambda);
    c->window = lambda < BROAD ? 2 * asin(lambda / BROAD) : pi; // to e^-25
    place_nodes(c, -c->window, c->window);
    if (lambda < BROAD)
        for (int i = 0; i < 2 * NODES; i++)
            c->weight[i] *= light(c->kappa, c->sin_half[i]);
}

static void add_powers(double sum[POWERS + 1], double weight, double u)
{
    for (int k = 0; k <= POWERS; k++, weight *= u)
        sum[k] += weight;
}

// A piece of the window, [a, b], that ends at the fold.
static void add_piece(double sum[POWERS + 1], const struct column *c,
                      double phi, const double ends[2])
{
    double mid = (ends[0] + ends[1]) / 2, half = (ends[1] - ends[0]) / 2;
    for (int i = 0; i < NODES; i++) {
        double x = mid + half * c->rule->x[i];
        double g = half * c->rule->w[i] * light(c->kappa, sin(x / 2));
        add_powers(sum, g, fabs(cos((phi - x) / 2)));
    }
}

static void cosine_powers(double sum[POWERS + 1], const struct column *c,
                          double phi)
{
    double cp = cos(phi / 2), sp = sin(phi / 2);
    memset(sum, 0, (POWERS + 1) * sizeof *sum);
    if (c->window < pi && phi - pi > -c->window) { // fold at x = phi - pi
        const double left[2] = {-c->window, phi - pi};
        const double right[2] = {phi - pi, c->window};
        add_piece(sum, c, phi, left);
        add_piece(sum, c, phi, right);
        return;
    }
    for (int i = 0; i < 2 * NODES; i++) {
        double ci = c->cos_half[i], si = c->sin_half[i];
        if (c->window < pi)
            add_powers(sum, c->weight[i], fabs(cp * ci + sp * si));
        else
            add_powers(sum, c->weight[i] * light(c->kappa, sp * ci - cp * si),
                       ci);
    }
}

static void make_cosine(struct xu_tables *t, const struct rule *rule)
{
    size_t half = (size_t)t->columns * (size_t)t->rows * 4;
    float *odd = t->rgba[XU_TABLES_COSINE], *even = odd + half;
    for (int i = 0; i < t->columns; i++) {
        struct column c;
        start_column(&c, rule, 1e-3 * pow(1e4, i / (t->columns - 1.0)));
        for (int j = 0; j < t->rows; j++) {
            double sum[POWERS + 1];
            cosine_powers(sum, &c, pi * j / (t->rows - 1));
            size_t at = 4 * ((size_t)j * (size_t)t->columns + (size_t)i);
            for (int k = 1; k <= POWERS; k++)
                (k % 2 ? odd : even)[at + (size_t)(k - 1) / 2] =
                    (float)(sum[k] / sum[0]);
        }
    }
}

// --- H_k --------------------------------------------------------------------
// With Schlick's F = F0 + (1 - F0) p, p = (1 - c cos g)^5 and h = sin g,
//   (1 - F)^2   = (1 - F0)^2 (1 - p)^2
//   (1 - F)^2 F = (1 - F0)^2 (1 - p)^2 (F0 + (1 - F0) p).
// Divided by their value at h = 0 both lose (1 - F0)^2; and (1 - p)/(1 - p(0))
// is taken as cos g P(c cos g) / P(c), P a polynomial that is 5 at grazing,
// which leaves no 0/0 at theta_d = pi/2.
static double unfold(double u) // (1 - (1 - u)^5) / u
{
    return 5 + u * (-10 + u * (10 + u * (-5 + u)));
}

static void make_row(struct xu_tables *t, const struct rule *rule, int row)
{
    double c = cos(pi / 2 * row / (t->rows - 1)), flat[3] = {0}, steep[3] = {0};
    for (int i = 0; i < NODES; i++) {
        double g = pi / 4 * (1 + rule->x[i]), u = cos(g), h = sin(g);
        double r = u * unfold(c * u) / unfold(c);
        double w = 2 * pi / 4 * rule->w[i] * u * r * r, p = pow(1 - c * u, 5);
        for (int k = 0; k < 3; k++, w *= h * h) {
            flat[k] += w;
            steep[k] += w * p;
        }
    }
    for (int i = 0; i < t->columns; i++) {
        double eta = pow(10, i / (t->columns - 1.0));
        double f0 = (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1));
        size_t at = 4 * ((size_t)row * (size_t)t->columns + (size_t)i);
        for (size_t k = 0; k < 3; k++) {
            t->rgba[XU_TABLES_TT][at + k] = (float)flat[k];
            t->rgba[XU_TABLES_TRT][at + k] =
                (float)(f0 * flat[k] + (1 - f0) * steep[k]);
        }
    }
}

struct xu_tables *xu_tables_create(int times)
{
    struct xu_tables *t = bytes_zalloc(1, sizeof *t);
    t->times = times;
    t->columns = 128 * times;
    t->rows = 64 * times;
    size_t cells = (size_t)t->columns * (size_t)t->rows;
    for (int i = 0; i < XU_TABLES_UNITS; i++)
        t->rgba[i] = bytes_zalloc(i == XU_TABLES_COSINE ? 8 * cells : 4 * cells,
                                  sizeof(float));
    struct rule rule;
    quadrature_legendre(NODES, rule.x, rule.w);
    make_cosine(t, &rule);
    for (int row = 0; row < t->rows; row++)
        make_row(t, &rule, row);
    return t;
}

static void upload(struct xu_tables *t)
{
    static const char *const name[XU_TABLES_UNITS] = {"xu cosine", "xu tt",
                                                      "xu trt"};
    gl.CreateTextures(GL_TEXTURE_2D, XU_TABLES_UNITS, t->texture);
    for (int i = 0; i < XU_TABLES_UNITS; i++) {
        GLuint id = t->texture[i];
        int rows = i == XU_TABLES_COSINE ? 2 * t->rows : t->rows;
        gl.TextureStorage2D(id, 1, GL_RGBA32F, t->columns, rows);
        gl.TextureSubImage2D(id, 0, 0, 0, t->columns, rows, GL_RGBA, GL_FLOAT,
                             t->rgba[i]);
        gl.TextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl.TextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        gl.TextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        gl.TextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        gl.ObjectLabel(GL_TEXTURE, id, -1, name[i]);
    }
}

void xu_tables_bind(struct xu_tables *t)
{
    if (!t->texture[0])
        upload(t);
    for (int i = 0; i < XU_TABLES_UNITS; i++)
        gl.BindTextureUnit((GLuint)i, t->texture[i]);
}

void xu_tables_destroy(struct xu_tables *t)
{
    if (!t)
        return;
    if (t->texture[0])
        gl.DeleteTextures(XU_TABLES_UNITS, t->texture);
    for (int i = 0; i < XU_TABLES_UNITS; i++)
        free(t->rgba[i]);
    free(t);
}
