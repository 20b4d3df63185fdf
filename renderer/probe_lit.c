// probe_lit.c - makes tables of lights as a picture does and sends cases
// through shaders/probe_lit.comp.  Reading and checking text is the verb's.
#include "renderer/probe_lit.h"

#include <math.h>
#include <stdlib.h>

#include "protocol/bytes.h"
#include "renderer/fast_tables.h"
#include "renderer/gl.h"
#include "renderer/glsl.h"
#include "renderer/lights.h"
#include "renderer/probe.h"
#include "renderer/program.h"

enum { AT_COUNT, BATCH = 8192, GROUP = 64, ROWS = 128 };
enum { OPAQUE = 1, MULTIPLE = 2, NOTING = 4, VARIANTS = 8 };

struct probe_lit {
    struct lit_fibre fibre;
    struct fast_tables *fast;
    struct dual_tables *dual;
    struct lit_tables *lit;
    struct lights lights;
    unsigned params;               // uniform block
    unsigned cases, results, hits; // buffers of a batch
    unsigned program[VARIANTS];    // 0 until first needed
    uint32_t *note;                // where hits go, or NULL
};

struct probe_lit *probe_lit_create(struct error *err)
{
    struct probe_lit *p = bytes_zalloc(1, sizeof *p);
    p->fast = fast_tables_create();
    p->dual = dual_tables_create();
    p->lit = lit_tables_create();
    lights_init(&p->lights);
    p->params = gl_buffer(16 * ROWS, NULL, "probe parameters");
    p->cases = gl_buffer(BATCH * PROBE_LIT_INPUTS * sizeof(float), NULL,
                         "probe cases");
    p->results = gl_buffer(BATCH * PROBE_LIT_OUTPUTS * sizeof(float), NULL,
                           "probe results");
    p->hits = gl_buffer(BATCH * PROBE_GUARD_WORDS * sizeof(uint32_t), NULL,
                        "probe guards");
    if (gl_check("making the probe's buffers", err))
        return p;
    probe_lit_destroy(p);
    return NULL;
}

void probe_lit_destroy(struct probe_lit *p)
{
    if (!p)
        return;
    for (int i = 0; i < VARIANTS; i++)
        program_drop(p->program[i]);
    gl.DeleteBuffers(1, &p->params);
    gl.DeleteBuffers(1, &p->cases);
    gl.DeleteBuffers(1, &p->results);
    gl.DeleteBuffers(1, &p->hits);
    lights_finish(&p->lights);
    lit_tables_destroy(p->lit);
    dual_tables_destroy(p->dual);
    fast_tables_destroy(p->fast);
    free(p);
}

void probe_lit_note_guards(struct probe_lit *p, uint32_t *hits)
{
    p->note = hits;
}

// The parameter block of a picture of this fibre.
static void put_params(const struct probe_lit *p)
{
    const struct dual_fibre *f = &p->fibre.fibre;
    const double deg = 180 / M_PI;
    float values[4 * ROWS];
    struct params all;
    params_defaults(&all);
    all.fibre.eta = (float)f->eta;
    for (int k = 0; k < 3; k++)
        all.fibre.sigma_a[k] = (float)f->sigma_a[k];
    all.fibre.a = (float)f->a;
    all.fibre.alpha_r = (float)(f->alpha[0] * deg);
    all.fibre.alpha_tt = (float)(f->alpha[1] * deg);
    all.fibre.alpha_trt = (float)(f->alpha[2] * deg);
    all.fibre.beta_r = (float)(f->beta[0] * deg);
    all.fibre.beta_tt = (float)(f->beta[1] * deg);
    all.fibre.beta_trt = (float)(f->beta[2] * deg);
    all.fibre.w_c = (float)(f->w_c * deg);
    all.fibre.delta_eta = (float)f->delta_eta;
    all.fibre.d_b = p->fibre.d_b;
    glsl_params_values(&all, values);
    gl.NamedBufferSubData(p->params, 0, 16 * params_row_count, values);
}

void probe_lit_fibre(struct probe_lit *p, const struct lit_fibre *f)
{
    p->fibre = *f;
    fast_tables_update(p->fast, &f->fibre);
    if (f->multiple)
        dual_tables_update(p->dual, &f->fibre, DUAL_SCHEME_BEST);
    lit_tables_fibre(p->lit, f);
    put_params(p);
}

// What passes and probe read.
static bool bind_inputs(struct probe_lit *p, struct error *err)
{
    if (!fast_tables_bind(p->fast, err))
        return false;
    if (p->fibre.multiple)
        dual_tables_bind(p->dual);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, GLSL_PARAMS_BINDING, p->params);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, LIGHTS_BINDING, p->lights.block);
    return true;
}

bool probe_lit_lights(struct probe_lit *p, const struct lit_lights *lights,
                      struct error *err)
{
    static struct sky_fit sky;
    struct params all;
    params_defaults(&all);
    all.quality.light_bound = all.quality.group_deg = 0;
    sky.count = lights->count;
    for (int i = 0; i < sky.count; i++)
        sky.light[i] = (struct sky_light){
            .direction = {0, 0, 1},
            .lambda = (double)lights->lambda[i],
            .radiance = {1, 1, 1},
        };
    lights_put(&p->lights, &sky, &all);
    lights_tint(&p->lights, &sky, &all, false);
    return bind_inputs(p, err) &&
           lit_tables_lights(p->lit, lights, &p->lights, err) &&
           lit_tables_make(p->lit, true, err);
}

static unsigned program_of(struct probe_lit *p, struct error *err)
{
    static const char *const words[VARIANTS] = {
        "",
        "XU_NO_TT_TRT",
        "WITH_MULTIPLE",
        "WITH_MULTIPLE XU_NO_TT_TRT",
        "GUARDS",
        "GUARDS XU_NO_TT_TRT",
        "GUARDS WITH_MULTIPLE",
        "GUARDS WITH_MULTIPLE XU_NO_TT_TRT"};
    const int i = (p->fibre.opaque ? OPAQUE : 0) +
                  (p->fibre.multiple ? MULTIPLE : 0) + (p->note ? NOTING : 0);
    if (!p->program[i])
        p->program[i] = program_compute("probe_lit.comp", words[i], err);
    return p->program[i];
}

static void take(struct probe_lit *p, size_t n, float *results)
{
    const size_t words = n * PROBE_GUARD_WORDS;
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(
        p->results, 0, (GLsizeiptr)(n * PROBE_LIT_OUTPUTS * sizeof *results),
        results);
    if (!p->note)
        return;
    gl.GetNamedBufferSubData(p->hits, 0, (GLsizeiptr)(words * sizeof *p->note),
                             p->note);
    p->note += words;
}

bool probe_lit_run(struct probe_lit *p, const float *cases, size_t count,
                   float *results, struct error *err)
{
    const size_t in = PROBE_LIT_INPUTS, out = PROBE_LIT_OUTPUTS;
    const unsigned program = program_of(p, err);
    if (!program || !bind_inputs(p, err) || !lit_tables_make(p->lit, true, err))
        return false;
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, p->cases);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->results);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, p->hits);
    program_use(program);
    while (count > 0) {
        size_t n = count < BATCH ? count : BATCH;
        gl.NamedBufferSubData(p->cases, 0, (GLsizeiptr)(n * in * sizeof *cases),
                              cases);
        gl.ProgramUniform1ui(program, AT_COUNT, (GLuint)n);
        gl.DispatchCompute((GLuint)((n + GROUP - 1) / GROUP), 1, 1);
        take(p, n, results);
        cases += n * in;
        results += n * out;
        count -= n;
    }
    return gl_check("running the probe", err);
}
