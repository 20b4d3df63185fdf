// probe.c - sends cases through shaders/probe.comp.  A batch goes through the
// circular variant, the eccentric one, or both, whichever its cases ask for,
// so that what is measured is what a picture runs.  Reading and checking text
// is the verb's.
#include "renderer/probe.h"

#include <stdio.h>
#include <stdlib.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"
#include "renderer/xu_tables.h"

enum { CIRCULAR, ECCENTRIC, NOTING, KINDS = 4, COLUMN_A = 9, GROUP = 64 };
// Uniform locations in probe.comp.
enum { AT_COUNT = 0, AT_DELTA_ETA = 1 };

struct probe {
    struct probe_setup setup;
    unsigned program[KINDS]; // 0 until first needed; NOTING + kind: guards
    unsigned cases, results; // buffers of a batch
    unsigned hits;           // 0 until first needed
    uint32_t *note;          // where hits go, or NULL
    struct xu_tables *tables;
};

struct probe *probe_create(const struct probe_setup *setup, struct error *err)
{
    struct probe *p = bytes_zalloc(1, sizeof *p);
    p->setup = *setup;
    p->tables = xu_tables_create(setup->tables);
    gl.CreateBuffers(1, &p->cases);
    gl.CreateBuffers(1, &p->results);
    gl.NamedBufferStorage(p->cases, PROBE_BATCH * PROBE_INPUTS * sizeof(float),
                          NULL, GL_DYNAMIC_STORAGE_BIT);
    gl.NamedBufferStorage(p->results,
                          PROBE_BATCH * PROBE_OUTPUTS * sizeof(float), NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, p->cases, -1, "probe cases");
    gl.ObjectLabel(GL_BUFFER, p->results, -1, "probe results");
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
            gl.DeleteProgram(p->program[kind]);
    gl.DeleteBuffers(1, &p->cases);
    gl.DeleteBuffers(1, &p->results);
    gl.DeleteBuffers(1, &p->hits);
    xu_tables_destroy(p->tables);
    free(p);
}

void probe_note_guards(struct probe *p, uint32_t *hits)
{
    p->note = hits;
    if (p->hits || !hits)
        return;
    gl.CreateBuffers(1, &p->hits);
    gl.NamedBufferStorage(p->hits,
                          PROBE_BATCH * PROBE_GUARD_WORDS * sizeof *hits, NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, p->hits, -1, "probe guards");
}

static bool dispatch(struct probe *p, int kind, unsigned count,
                     struct error *err)
{
    if (!p->program[kind]) {
        char defines[96];
        snprintf(defines, sizeof defines, "XU_M=%d%s%s%s%s", p->setup.m,
                 p->setup.fine_nodes ? " XU_FINE_NODES" : "",
                 kind % NOTING == ECCENTRIC ? " XU_ECCENTRIC" : "",
                 p->setup.opaque ? " XU_NO_TT_TRT" : "",
                 kind >= NOTING ? " GUARDS" : "");
        p->program[kind] = program_compute("probe.comp", defines, err);
        if (!p->program[kind])
            return false;
        gl.ProgramUniform1f(p->program[kind], AT_DELTA_ETA,
                            (float)p->setup.delta_eta);
    }
    gl.ProgramUniform1ui(p->program[kind], AT_COUNT, count);
    gl.UseProgram(p->program[kind]);
    gl.DispatchCompute((count + GROUP - 1) / GROUP, 1, 1);
    return true;
}

bool probe_run(struct probe *p, const float *cases, size_t count,
               float *results, struct error *err)
{
    while (count > 0) {
        size_t n = count < PROBE_BATCH ? count : PROBE_BATCH;
        bool need[NOTING] = {false};
        for (size_t i = 0; i < n; i++)
            need[cases[PROBE_INPUTS * i + COLUMN_A] != 1.0f] = true;
        gl.NamedBufferSubData(
            p->cases, 0, (GLsizeiptr)(n * PROBE_INPUTS * sizeof *cases), cases);
        xu_tables_bind(p->tables);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, p->cases);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->results);
        if (p->note)
            gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, p->hits);
        for (int kind = 0; kind < NOTING; kind++)
            if (need[kind] &&
                !dispatch(p, kind + (p->note ? NOTING : 0), (unsigned)n, err))
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
