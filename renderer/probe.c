// probe.c - sends cases through shaders/probe.comp.  A batch goes through the
// circular variant, the eccentric one, or both, whichever its cases ask for,
// so that what is measured is what a picture runs.  Reading and checking text
// is the verb's.
#include "renderer/probe.h"

#include <stdio.h>
#include <stdlib.h>

#include "protocol/bytes.h"
#include "renderer/best_lobes.h"
#include "renderer/gl.h"
#include "renderer/program.h"
#include "renderer/xu_tables.h"

enum { CIRCULAR, ECCENTRIC, NOTING, KINDS = 4, GROUP = 64 };
enum { COLUMN_W_C = 8, COLUMN_A = 9 };
// Uniform locations in probe.comp.
enum { AT_COUNT = 0, AT_DELTA_ETA = 1, AT_FIRST = 2 };

struct probe {
    struct probe_setup setup;
    unsigned program[KINDS];  // 0 until first needed; NOTING + kind: guards
    unsigned cases, results;  // buffers of a batch
    unsigned hits;            // 0 until first needed
    uint32_t *note;           // where hits go, or NULL
    struct xu_tables *tables; // scheme `paper`
    struct best_lobes *lobes; // scheme `best`
};

struct probe *probe_create(const struct probe_setup *setup, struct error *err)
{
    struct probe *p = bytes_zalloc(1, sizeof *p);
    p->setup = *setup;
    if (setup->best)
        p->lobes = best_lobes_create();
    else
        p->tables = xu_tables_create(setup->tables);
    p->cases = gl_buffer(PROBE_BATCH * PROBE_INPUTS * sizeof(float), NULL,
                         "probe cases");
    p->results = gl_buffer(PROBE_BATCH * PROBE_OUTPUTS * sizeof(float), NULL,
                           "probe results");
    if (gl_check("making the probe's buffers", err))
        return p;
    probe_destroy(p);
    return NULL;
}

void probe_destroy(struct probe *p)
{
    if (!p)
        return;
    for (int kind = 0; kind < KINDS; kind++)
        if (p->program[kind])
            program_drop(p->program[kind]);
    gl.DeleteBuffers(1, &p->cases);
    gl.DeleteBuffers(1, &p->results);
    gl.DeleteBuffers(1, &p->hits);
    xu_tables_destroy(p->tables);
    best_lobes_destroy(p->lobes);
    free(p);
}

void probe_note_guards(struct probe *p, uint32_t *hits)
{
    p->note = hits;
    if (p->hits || !hits)
        return;
    p->hits = gl_buffer(PROBE_BATCH * PROBE_GUARD_WORDS * sizeof *hits, NULL,
                        "probe guards");
}

static bool make_program(struct probe *p, int kind, struct error *err)
{
    char defines[96];
    const struct probe_setup *s = &p->setup;
    if (p->program[kind])
        return true;
    snprintf(defines, sizeof defines, "%s=%d%s%s%s%s",
             s->best ? "XU_BEST" : "XU_M", s->best ? 1 : s->m,
             s->fine_nodes ? " XU_FINE_NODES" : "",
             kind % NOTING == ECCENTRIC ? " XU_ECCENTRIC" : "",
             s->opaque ? " XU_NO_TT_TRT" : "", kind >= NOTING ? " GUARDS" : "");
    p->program[kind] = program_compute("probe.comp", defines, err);
    if (p->program[kind])
        gl.ProgramUniform1f(p->program[kind], AT_DELTA_ETA,
                            (float)s->delta_eta);
    return p->program[kind] != 0;
}

static bool dispatch(struct probe *p, int kind, size_t first, size_t count,
                     struct error *err)
{
    kind += p->note ? NOTING : 0;
    if (!make_program(p, kind, err))
        return false;
    gl.ProgramUniform1ui(p->program[kind], AT_FIRST, (GLuint)first);
    gl.ProgramUniform1ui(p->program[kind], AT_COUNT, (GLuint)count);
    gl.UseProgram(p->program[kind]);
    gl.DispatchCompute((GLuint)((count + GROUP - 1) / GROUP), 1, 1);
    return true;
}

static bool run_paper(struct probe *p, const float *cases, size_t count,
                      struct error *err)
{
    bool need[NOTING] = {false};
    for (size_t i = 0; i < count; i++)
        need[cases[PROBE_INPUTS * i + COLUMN_A] != 1.0f] = true;
    xu_tables_bind(p->tables);
    for (int kind = 0; kind < NOTING; kind++)
        if (need[kind] && !dispatch(p, kind, 0, count, err))
            return false;
    return true;
}

static bool same_fibre(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[COLUMN_W_C] == b[COLUMN_W_C] &&
           a[COLUMN_A] == b[COLUMN_A];
}

// Fibre by fibre, for each has its own lobes.
static bool run_best(struct probe *p, const float *cases, size_t count,
                     struct error *err)
{
    for (size_t i = 0, end; i < count; i = end) {
        const float *v = cases + PROBE_INPUTS * i;
        for (end = i + 1;
             end < count && same_fibre(v, cases + PROBE_INPUTS * end);)
            end++;
        const double sigma = (double)v[1];
        const struct best_fibre f = {.eta = (double)v[0],
                                     .sigma_a = {sigma, sigma, sigma},
                                     .a = (double)v[COLUMN_A],
                                     .w_c = (double)v[COLUMN_W_C]};
        best_lobes_update(p->lobes, &f);
        best_lobes_bind(p->lobes);
        if (!dispatch(p, f.a != 1 ? ECCENTRIC : CIRCULAR, i, end - i, err))
            return false;
    }
    return true;
}

bool probe_run(struct probe *p, const float *cases, size_t count,
               float *results, struct error *err)
{
    while (count > 0) {
        size_t n = count < PROBE_BATCH ? count : PROBE_BATCH;
        gl.NamedBufferSubData(
            p->cases, 0, (GLsizeiptr)(n * PROBE_INPUTS * sizeof *cases), cases);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, p->cases);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->results);
        if (p->note)
            gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, p->hits);
        if (!(p->setup.best ? run_best : run_paper)(p, cases, n, err))
            return false;
        gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl.GetNamedBufferSubData(
            p->results, 0, (GLsizeiptr)(n * PROBE_OUTPUTS * sizeof *results),
            results);
        const size_t row = PROBE_GUARD_WORDS * sizeof *p->note;
        if (p->note)
            gl.GetNamedBufferSubData(p->hits, 0, (GLsizeiptr)(n * row),
                                     p->note);
        if (!gl_check("running the probe", err))
            return false;
        cases += n * PROBE_INPUTS;
        results += n * PROBE_OUTPUTS;
        if (p->note)
            p->note += n * PROBE_GUARD_WORDS;
        count -= n;
    }
    return true;
}
