// crossings_probe.c - see the header.
#include "renderer/crossings_probe.h"

#include <stdio.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

enum { GROUP = 64 };
enum { AT_COUNT = 0, AT_ATTENUATION = 1, AT_RAYS = 2 };

static unsigned buffer(size_t size, const void *data)
{
    unsigned b = 0;
    gl.CreateBuffers(1, &b);
    gl.NamedBufferStorage(b, (GLsizeiptr)size, data, 0);
    return b;
}

bool crossings_probe(const struct crossings_probe_run *run,
                     const struct crossings_place *places, int count,
                     int lights, struct crossings_result *results,
                     struct error *err)
{
    char defines[96] = "";
    if (run->rays > 0)
        snprintf(defines, sizeof defines, "SHADOW_RAYS%s",
                 run->strands->opacity ? " WITH_OPACITY" : "");
    else if (run->crossings && run->crossings->options.map)
        snprintf(defines, sizeof defines, "SHADOW_MAP");
    if (run->given_nodes)
        snprintf(defines, sizeof defines, "GIVEN_NODES");
    if (run->note_guards)
        strcat(defines, " GUARDS");
    const GLuint program =
        program_compute("crossings_probe.comp", defines, err);
    if (!program)
        return false;
    const size_t size =
        (size_t)count * (size_t)lights * sizeof(struct crossings_result);
    const GLuint in = buffer((size_t)count * sizeof *places, places);
    const GLuint out = buffer(size, NULL);
    const float *a = run->attenuation;
    gl.ProgramUniform2ui(program, AT_COUNT, (GLuint)count, (GLuint)lights);
    gl.ProgramUniform4f(program, AT_ATTENUATION, a[0], a[1], a[2], a[3]);
    if (run->rays > 0)
        gl.ProgramUniform1ui(program, AT_RAYS, (GLuint)run->rays);
    if (run->crossings)
        crossings_bind(run->crossings, run->strands);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, in);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, out);
    gl.UseProgram(program);
    gl.DispatchCompute((GLuint)(count + GROUP - 1) / GROUP, (GLuint)lights, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(out, 0, (GLsizeiptr)size, results);
    gl.DeleteBuffers(1, &in);
    gl.DeleteBuffers(1, &out);
    program_drop(program);
    return gl_check("running the shadows' probe", err);
}
