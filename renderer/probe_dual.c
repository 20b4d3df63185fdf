// probe_dual.c - sends cases through shaders/probe_dual.comp.  Reading and
// checking text is the verb's.
#include "renderer/probe_dual.h"

#include <stdio.h>
#include <stdlib.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"
#include "renderer/xu_tables.h"

enum { MULTIPLE, HALF, KINDS, NOTING = KINDS, GROUP = 64, BATCH = 8192 };
enum { AT_COUNT = 0, AT_FIBRE = 1, FIBRE_VALUES = 13 };

struct probe_dual {
    struct probe_setup setup;
    enum dual_scheme scheme;
    struct dual_fibre fibre;
    unsigned program[2 * KINDS]; // 0 until first needed; NOTING + kind: guards
    unsigned cases, results;     // buffers of a batch
    unsigned hits;               // 0 until first needed
    uint32_t *note;              // where hits go, or NULL
    struct xu_tables *xu;        // scheme `paper` reads them
    struct dual_tables *dual;
};

static const struct {
    size_t in, out;
} sizes[KINDS] = {{PROBE_DUAL_INPUTS, PROBE_DUAL_OUTPUTS},
                  {PROBE_DUAL_HALF_INPUTS, PROBE_DUAL_HALF_OUTPUTS}};

struct probe_dual *probe_dual_create(const struct probe_setup *setup,
                                     enum dual_scheme scheme, struct error *err)
{
    struct probe_dual *p = bytes_zalloc(1, sizeof *p);
    p->setup = *setup;
    p->scheme = scheme;
    p->xu = xu_tables_create(setup->tables);
    p->dual = dual_tables_create();
    p->cases = gl_buffer(BATCH * PROBE_DUAL_INPUTS * sizeof(float), NULL,
                         "probe cases");
    p->results = gl_buffer(BATCH * PROBE_DUAL_OUTPUTS * sizeof(float), NULL,
                           "probe results");
    if (gl_check("making the probe's buffers", err))
        return p;
    probe_dual_destroy(p);
    return NULL;
}

void probe_dual_destroy(struct probe_dual *p)
{
    if (!p)
        return;
    for (int kind = 0; kind < 2 * KINDS; kind++)
        if (p->program[kind])
            program_drop(p->program[kind]);
    gl.DeleteBuffers(1, &p->cases);
    gl.DeleteBuffers(1, &p->results);
    gl.DeleteBuffers(1, &p->hits);
    xu_tables_destroy(p->xu);
    dual_tables_destroy(p->dual);
    free(p);
}

struct dual_fibre probe_dual_grey(const struct exact_case *c)
{
    return (struct dual_fibre){.eta = c->eta,
                               .sigma_a = {c->sigma_a, c->sigma_a, c->sigma_a},
                               .a = c->a,
                               .alpha = {c->alpha[0], c->alpha[1], c->alpha[2]},
                               .beta = {c->beta[0], c->beta[1], c->beta[2]},
                               .w_c = c->w_c,
                               .delta_eta = c->delta_eta};
}

void probe_dual_fibre(struct probe_dual *p, const struct dual_fibre *f)
{
    p->fibre = *f;
    dual_tables_update(p->dual, f, p->scheme);
}

const struct dual_tables *probe_dual_tables(const struct probe_dual *p)
{
    return p->dual;
}

void probe_dual_note_guards(struct probe_dual *p, uint32_t *hits)
{
    p->note = hits;
    if (p->hits || !hits)
        return;
    p->hits = gl_buffer(BATCH * PROBE_GUARD_WORDS * sizeof *hits, NULL,
                        "probe guards");
}

// Hits of a batch of n cases that has run.
static void take_hits(struct probe_dual *p, size_t n)
{
    size_t words = n * PROBE_GUARD_WORDS;
    gl.GetNamedBufferSubData(p->hits, 0, (GLsizeiptr)(words * sizeof *p->note),
                             p->note);
    p->note += words;
}

static bool make_program(struct probe_dual *p, int kind, struct error *err)
{
    char defines[128];
    if (p->program[kind])
        return true;
    snprintf(defines, sizeof defines, "XU_M=%d%s%s%s%s%s", p->setup.m,
             p->setup.fine_nodes ? " XU_FINE_NODES" : "",
             p->scheme == DUAL_SCHEME_PAPER ? " DUAL_PAPER" : "",
             p->setup.opaque ? " XU_NO_TT_TRT" : "",
             kind % NOTING == HALF ? " PROBE_HALF" : "",
             kind >= NOTING ? " GUARDS" : "");
    p->program[kind] = program_compute("probe_dual.comp", defines, err);
    return p->program[kind] != 0;
}

static void set_fibre(const struct probe_dual *p, unsigned program)
{
    const struct dual_fibre *f = &p->fibre;
    const double v[FIBRE_VALUES] = {
        f->eta,      f->sigma_a[0], f->sigma_a[1], f->sigma_a[2], f->a,
        f->alpha[0], f->alpha[1],   f->alpha[2],   f->beta[0],    f->beta[1],
        f->beta[2],  f->w_c,        f->delta_eta};
    for (int i = 0; i < FIBRE_VALUES; i++)
        gl.ProgramUniform1f(program, AT_FIBRE + i, (float)v[i]);
}

static bool run(struct probe_dual *p, int kind, const float *cases,
                size_t count, float *results, struct error *err)
{
    size_t in = sizes[kind].in, out = sizes[kind].out;
    kind += p->note ? NOTING : 0;
    if (!make_program(p, kind, err))
        return false;
    set_fibre(p, p->program[kind]);
    if (p->note)
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, p->hits);
    xu_tables_bind(p->xu);
    dual_tables_bind(p->dual);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, p->cases);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->results);
    gl.UseProgram(p->program[kind]);
    while (count > 0) {
        size_t n = count < BATCH ? count : BATCH;
        gl.NamedBufferSubData(p->cases, 0, (GLsizeiptr)(n * in * sizeof *cases),
                              cases);
        gl.ProgramUniform1ui(p->program[kind], AT_COUNT, (GLuint)n);
        gl.DispatchCompute((GLuint)((n + GROUP - 1) / GROUP), 1, 1);
        gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl.GetNamedBufferSubData(
            p->results, 0, (GLsizeiptr)(n * out * sizeof *results), results);
        if (p->note)
            take_hits(p, n);
        cases += n * in;
        results += n * out;
        count -= n;
    }
    return gl_check("running the probe", err);
}

bool probe_dual_multiple(struct probe_dual *p, const float *cases, size_t count,
                         float *results, struct error *err)
{
    return run(p, MULTIPLE, cases, count, results, err);
}

bool probe_dual_half(struct probe_dual *p, const float *cases, size_t count,
                     float *results, struct error *err)
{
    return run(p, HALF, cases, count, results, err);
}
