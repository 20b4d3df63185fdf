// sky_exr_colour.c - the matrix between two sets of primaries: SMPTE RP 177
// for each set, Bradford's cone responses between the whites (ICC.1, annex E).
#include "renderer/sky_exr_colour.h"

#include <math.h>
#include <string.h>

struct matrix {
    double m[3][3];
};

static bool invert(const struct matrix *a, struct matrix *out)
{
    double det = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int r = (j + 1) % 3, s = (j + 2) % 3;
            int t = (i + 1) % 3, u = (i + 2) % 3;
            out->m[i][j] = a->m[r][t] * a->m[s][u] - a->m[r][u] * a->m[s][t];
        }
    for (int j = 0; j < 3; j++)
        det += a->m[0][j] * out->m[j][0];
    if (!(fabs(det) > 1e-9))
        return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out->m[i][j] /= det;
    return true;
}

static struct matrix multiply(const struct matrix *a, const struct matrix *b)
{
    struct matrix r = {{{0}}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                r.m[i][j] += a->m[i][k] * b->m[k][j];
    return r;
}

static void apply(const struct matrix *a, const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a->m[i][0] * v[0] + a->m[i][1] * v[1] + a->m[i][2] * v[2];
}

static bool white_xyz(const double xy[2], double out[3])
{
    if (!(xy[1] > 0.05) || !(xy[0] > 0) || !(xy[0] + xy[1] < 1))
        return false;
    out[0] = xy[0] / xy[1];
    out[1] = 1;
    out[2] = (1 - xy[0] - xy[1]) / xy[1];
    return true;
}

// RGB to XYZ: columns are the primaries, scaled so that (1, 1, 1) is white.
static bool to_xyz(const double p[4][2], struct matrix *out)
{
    struct matrix m, inverse;
    double white[3], scale[3];
    for (int k = 0; k < 3; k++) {
        m.m[0][k] = p[k][0];
        m.m[1][k] = p[k][1];
        m.m[2][k] = 1 - p[k][0] - p[k][1];
    }
    if (!invert(&m, &inverse) || !white_xyz(p[3], white))
        return false;
    apply(&inverse, white, scale);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out->m[i][k] = m.m[i][k] * scale[k];
    return true;
}

static bool adapt(const double from[2], const double to[2], struct matrix *out)
{
    static const struct matrix bradford = {{{0.8951, 0.2664, -0.1614},
                                            {-0.7502, 1.7135, 0.0367},
                                            {0.0389, -0.0685, 1.0296}}};
    double a[3], b[3], cone_a[3], cone_b[3];
    struct matrix inverse, scaled;
    if (!white_xyz(from, a) || !white_xyz(to, b) ||
        !invert(&bradford, &inverse))
        return false;
    apply(&bradford, a, cone_a);
    apply(&bradford, b, cone_b);
    for (int i = 0; i < 3; i++) {
        if (!(cone_a[i] > 0.01) || !(cone_b[i] > 0.01))
            return false;
        for (int j = 0; j < 3; j++)
            scaled.m[i][j] = bradford.m[i][j] * cone_b[i] / cone_a[i];
    }
    *out = multiply(&inverse, &scaled);
    return true;
}

// What is to be multiplied onto colours of the given primaries.
static bool to_rec709(const double primaries[4][2], struct matrix *out)
{
    static const double rec709[4][2] = {
        {0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
    struct matrix theirs, white, ours, back;
    if (!to_xyz(primaries, &theirs) ||
        !adapt(primaries[3], rec709[3], &white) || !to_xyz(rec709, &ours) ||
        !invert(&ours, &back))
        return false;
    theirs = multiply(&white, &theirs);
    *out = multiply(&back, &theirs);
    return true;
}

bool sky_exr_colour_convert(struct sky_pixels *p, const double primaries[4][2])
{
    struct matrix m;
    double off = 0;
    if (!to_rec709(primaries, &m))
        return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            off = fmax(off, fabs(m.m[i][j] - (i == j)));
    if (!(off > 0.002) || !(off < 100))
        return false;
    size_t count = (size_t)p->width * (size_t)p->height;
    for (size_t i = 0; i < count; i++) {
        float *rgb = p->rgb + 3 * i;
        if (!isfinite(rgb[0]) || !isfinite(rgb[1]) || !isfinite(rgb[2]))
            continue; // a sum would spread it; cleaning counts and mends it
        double in[3] = {(double)rgb[0], (double)rgb[1], (double)rgb[2]};
        double res[3];
        apply(&m, in, res);
        for (int k = 0; k < 3; k++)
            rgb[k] = (float)res[k];
    }
    return true;
}
