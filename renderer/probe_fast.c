// probe_fast.c - sends cases through shaders/probe_fast.comp.  Reading and
// checking text is the verb's.
#include "renderer/probe_fast.h"

#include <stdlib.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"

enum { AT_COUNT, AT_FIBRE, FIBRE_VALUES = 13, BATCH = 8192, GROUP = 64 };

struct probe_fast {
    struct dual_fibre fibre;
    struct fast_tables *tables;
    unsigned program, cases, results; // buffers of a batch
};

struct probe_fast *probe_fast_create(struct error *err)
{
    struct probe_fast *p = bytes_zalloc(1, sizeof *p);
    p->tables = fast_tables_create();
    p->program = program_compute("probe_fast.comp", "XU_M=4", err);
    p->cases = gl_buffer(BATCH * PROBE_FAST_INPUTS * sizeof(float), NULL,
                         "probe cases");
    p->results = gl_buffer(BATCH * PROBE_FAST_OUTPUTS * sizeof(float), NULL,
                           "probe results");
    if (p->program && gl_check("making the probe's buffers", err))
        return p;
    probe_fast_destroy(p);
    return NULL;
}

void probe_fast_destroy(struct probe_fast *p)
{
    if (!p)
        return;
    program_drop(p->program);
    gl.DeleteBuffers(1, &p->cases);
    gl.DeleteBuffers(1, &p->results);
    fast_tables_destroy(p->tables);
    free(p);
}

void probe_fast_coarsen(struct probe_fast *p)
{
    fast_tables_coarsen(p->tables);
}

void probe_fast_fibre(struct probe_fast *p, const struct dual_fibre *f)
{
    p->fibre = *f;
    fast_tables_update(p->tables, f);
}

static void set_fibre(const struct probe_fast *p)
{
    const struct dual_fibre *f = &p->fibre;
    const double v[FIBRE_VALUES] = {
        f->eta,      f->sigma_a[0], f->sigma_a[1], f->sigma_a[2], f->a,
        f->alpha[0], f->alpha[1],   f->alpha[2],   f->beta[0],    f->beta[1],
        f->beta[2],  f->w_c,        f->delta_eta};
    for (int i = 0; i < FIBRE_VALUES; i++)
        gl.ProgramUniform1f(p->program, AT_FIBRE + i, (float)v[i]);
}

bool probe_fast_run(struct probe_fast *p, const float *cases, size_t count,
                    float *results, struct error *err)
{
    const size_t in = PROBE_FAST_INPUTS, out = PROBE_FAST_OUTPUTS;
    if (!fast_tables_bind(p->tables, err))
        return false;
    set_fibre(p);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, p->cases);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->results);
    gl.UseProgram(p->program);
    while (count > 0) {
        size_t n = count < BATCH ? count : BATCH;
        gl.NamedBufferSubData(p->cases, 0, (GLsizeiptr)(n * in * sizeof *cases),
                              cases);
        gl.ProgramUniform1ui(p->program, AT_COUNT, (GLuint)n);
        gl.DispatchCompute((GLuint)((n + GROUP - 1) / GROUP), 1, 1);
        gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl.GetNamedBufferSubData(
            p->results, 0, (GLsizeiptr)(n * out * sizeof *results), results);
        cases += n * in;
        results += n * out;
        count -= n;
    }
    return gl_check("running the probe", err);
}
