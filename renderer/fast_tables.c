// fast_tables.c - coefficients on the CPU, dispatches and buffers of the
// tables. What a ray does in a cross section is dual_azimuth.c's affair, what a
// cell holds, shaders/fast_pack.comp's.
#include "renderer/fast_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/crew.h"
#include "renderer/gl.h"
#include "renderer/program.h"

static const double pi = 3.14159265358979323846;

enum {
    D = FAST_TABLES_D,
    L = FAST_TABLES_L,
    P = FAST_TABLES_P,
    TERMS = FAST_TABLES_TERMS,
    WAYS = FAST_TABLES_WAYS,
    TERMS_LOCATION = 0,
    CELL_BYTES = 5 * 16, // TT and TRT two uvec4, R one
    VALUE_BYTES = 2 * 16
};

enum { COEFFICIENTS, FACTORS, COSINES, VALUES, CELLS, BUFFERS };
// What the passes write is bound as storage, 0 and 15, which the shading binds
// anew in any case; what they read is texels, here from 17 on.
enum { VALUES_BINDING = 0, CELLS_BINDING = 15, FIRST_UNIT = 17 };
static const unsigned format[BUFFERS] = {GL_RGBA32F, GL_R32F, GL_RGBA32F,
                                         GL_RGBA32F, GL_RGBA32UI};

struct fast_tables {
    float coefficient[D * TERMS][8]; // [theta_d][n]: TT, R; TRT, 0
    uint32_t way[WAYS][4]; // [theta_j]: a_f and betabar_f, 16 bits each
    int terms;
    struct dual_azimuth azimuth; // of the cross section that these are of
    double smooth[TERMS];
    unsigned made;                  // how often; 0: not of any
    const struct dual_tables *dual; // whose ways these are, and of which
    unsigned means;                 // of its updates
    bool stale, ways_stale, coarse;
    unsigned buffer[BUFFERS], texture[BUFFERS]; // 0 until bound for once
    unsigned values, pack;                      // programs
};

const char *fast_tables_refuse(const struct dual_fibre *f)
{
    // Of the last of 64 coefficients exp(-(n w_c)^2 / 4) is left: 1e-3.
    if (f->w_c < 0.082)
        return "fibre.w_c is below 4.7 degrees";
    return f->a == 1 ? NULL : "fibre.a is not 1";
}

struct fast_tables *fast_tables_create(void)
{
    return bytes_zalloc(1, sizeof(struct fast_tables));
}

// Miller's downward recurrence, normalised by I_0 + 2 sum I_n = e^kappa.
void fast_tables_bessel(double kappa, int count, double *out)
{
    int from = count + 40 + (int)sqrt(80 * kappa);
    double next = 0, now = 1e-280, sum = 0;
    for (int n = from; n >= 0; n--) {
        if (n < count)
            out[n] = now;
        sum += n ? 2 * now : now;
        double before = next + 2 * n / kappa * now;
        next = now;
        now = before;
        if (now > 1e200) { // keep within range
            for (int k = n; k < count; k++)
                out[k] *= 1e-200;
            now *= 1e-200;
            next *= 1e-200;
            sum *= 1e-200;
        }
    }
    for (int n = 0; n < count; n++)
        out[n] /= sum;
}

void fast_tables_coarsen(struct fast_tables *t)
{
    t->coarse = true;
    t->made = 0;
}

// A piece of an update: what the coefficients at one theta_d are.
static void fill_row(void *context, size_t d)
{
    struct fast_tables *t = context;
    const double at = t->coarse ? (double)(d / 2 * 2 + 1) : (double)d + 0.5;
    double c[TERMS][DUAL_CHANNELS];
    dual_azimuth_cosines(&t->azimuth, cos(pi / 2 * at / D), t->terms, c);
    for (int n = 0; n < t->terms; n++) {
        float *to = t->coefficient[d * (size_t)t->terms + (size_t)n];
        for (int k = 0; k < 3; k++) {
            to[k] = (float)c[n][DUAL_TT + k];
            to[4 + k] =
                (float)(c[n][DUAL_TRT + k] * t->smooth[n] / t->smooth[0]);
        }
        to[3] = (float)c[n][DUAL_R];
        to[7] = 0;
    }
}

void fast_tables_update(struct fast_tables *t, const struct dual_fibre *f)
{
    const struct dual_section s = dual_azimuth_section(f);
    if (t->made > 0 && dual_azimuth_same(&s, &t->azimuth.section))
        return;
    dual_azimuth_init(&t->azimuth, &s);
    t->terms = s.w_c < 0.11 ? TERMS : 48;
    fast_tables_bessel(2 / (s.w_c * s.w_c), t->terms, t->smooth);
    crew_run(D, fill_row, t);
    t->made++;
    t->stale = true;
}

unsigned fast_tables_made(const struct fast_tables *t)
{
    return t->made;
}

static uint32_t part(double x)
{
    return (uint32_t)lrint(65535 * fmin(fmax(x, 0), 1));
}

void fast_tables_forward(struct fast_tables *t, const struct dual_tables *dual)
{
    const unsigned means = dual_tables_work(dual).means;
    if (t->dual == dual && t->means == means)
        return;
    for (int i = 0; i < WAYS; i++)
        for (int k = 0; k < 3; k++) {
            double m[2]; // a_f, beta2_f
            dual_tables_ahead(dual, pi * ((i + 0.5) / WAYS - 0.5), k, m);
            t->way[i][k] =
                part(m[0]) << 16 | part(sqrt(m[1]) / FAST_TABLES_BETA);
        }
    t->dual = dual;
    t->means = means;
    t->ways_stale = true;
}

// --- on the device ----------------------------------------------------------
// What lights make of the coefficients; after a slice's the number of those
// that count for something.
static unsigned make_factors(void)
{
    static float factor[L + 1][TERMS + 1];
    double value[TERMS];
    for (int l = 0; l < L; l++) {
        double lambda = FAST_TABLES_LAMBDA * exp(FAST_TABLES_STEP * (l + 0.5));
        fast_tables_bessel(2 / (lambda * lambda), TERMS, value);
        int count = 0;
        while (count < TERMS && value[count] > 1e-7 * value[0])
            count++;
        factor[l][TERMS] = (float)count;
        for (int n = 0; n < TERMS; n++)
            factor[l][n] = (float)(2 * pi * value[n]);
    }
    factor[L][TERMS] = TERMS;
    factor[L][0] = 1;
    for (int n = 1; n < TERMS; n++)
        factor[L][n] = n % 2 ? (float)((n % 4 == 1 ? 2 : -2) / (pi * n)) : 0;
    return gl_buffer(sizeof factor, factor, "fast factors");
}

static unsigned make_cosines(void)
{
    static float cosine[TERMS][P];
    for (int n = 0; n < TERMS; n++)
        for (int p = 0; p < P; p++)
            cosine[n][p] = (float)cos(n * pi * (p + 0.5) / P);
    return gl_buffer(sizeof cosine, cosine, "fast cosines");
}

// What there is of them: half of it would be believed to be all.
static void drop_objects(struct fast_tables *t)
{
    gl.DeleteBuffers(BUFFERS, t->buffer);
    gl.DeleteTextures(BUFFERS, t->texture);
    memset(t->buffer, 0, sizeof t->buffer);
    memset(t->texture, 0, sizeof t->texture);
}

static bool create_objects(struct fast_tables *t, struct error *err)
{
    if (!t->values)
        t->values = program_compute("fast_values.comp", NULL, err);
    if (!t->values)
        return false;
    if (!t->pack)
        t->pack = program_compute("fast_pack.comp", NULL, err);
    if (!t->pack)
        return false;
    unsigned *b = t->buffer;
    b[COEFFICIENTS] =
        gl_buffer(sizeof t->coefficient, NULL, "fast coefficients");
    b[FACTORS] = make_factors();
    b[COSINES] = make_cosines();
    b[VALUES] =
        gl_buffer((size_t)FAST_TABLES_CELLS * VALUE_BYTES, NULL, "fast values");
    b[CELLS] = gl_buffer((size_t)FAST_TABLES_CELLS * CELL_BYTES + sizeof t->way,
                         NULL, "fast cells");
    gl.CreateTextures(GL_TEXTURE_BUFFER, BUFFERS, t->texture);
    for (int i = 0; i < BUFFERS; i++)
        gl.TextureBuffer(t->texture[i], format[i], b[i]);
    gl.ObjectLabel(GL_TEXTURE, t->texture[CELLS], -1, "fast cells");
    if (gl_check("making tables of the fibre", err))
        return true;
    drop_objects(t);
    return false;
}

static void fill(struct fast_tables *t)
{
    gl.NamedBufferSubData(
        t->buffer[COEFFICIENTS], 0,
        (GLsizeiptr)(D * (size_t)t->terms * sizeof t->coefficient[0]),
        t->coefficient);
    for (unsigned i = 0; i < CELLS; i++)
        gl.BindTextureUnit(FIRST_UNIT + i, t->texture[i]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, VALUES_BINDING,
                      t->buffer[VALUES]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, CELLS_BINDING,
                      t->buffer[CELLS]);
    program_use(t->values);
    gl.ProgramUniform1ui(t->values, TERMS_LOCATION, (GLuint)t->terms);
    gl_dispatch_spread(FAST_TABLES_CELLS / 4 / 64); // narrow lights take longer
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    program_use(t->pack);
    gl_dispatch(FAST_TABLES_CELLS);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

bool fast_tables_bind(struct fast_tables *t, struct error *err)
{
    if (!t->texture[0] && !create_objects(t, err))
        return false;
    if (t->stale) {
        fill(t);
        t->stale = false;
    }
    if (t->ways_stale) {
        gl.NamedBufferSubData(t->buffer[CELLS],
                              (GLintptr)FAST_TABLES_CELLS * CELL_BYTES,
                              sizeof t->way, t->way);
        t->ways_stale = false;
    }
    gl.BindTextureUnit(FAST_TABLES_UNIT, t->texture[CELLS]);
    return true;
}

unsigned fast_tables_bytes(const struct fast_tables *t)
{
    return t && t->texture[0] ? FAST_TABLES_CELLS * (CELL_BYTES + VALUE_BYTES)
                              : 0;
}

void fast_tables_destroy(struct fast_tables *t)
{
    if (!t)
        return;
    if (t->texture[0])
        drop_objects(t);
    if (t->values)
        program_drop(t->values);
    if (t->pack)
        program_drop(t->pack);
    free(t);
}
