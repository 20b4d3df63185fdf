// program.c - puts embedded GLSL files together and hands them to the GL
// compiler.  Which variant to build is the caller's affair.
#include "renderer/program.h"

#include <stdio.h>
#include <string.h>

#include "renderer/embed.h"
#include "renderer/gl.h"
#include "renderer/glsl.h"
#include "renderer/program_pool.h"

enum { INCLUDES_MAX = 32 };

struct expansion {
    struct buf *out;
    const char *defines;
    char done[INCLUDES_MAX][48]; // files already in
    int done_count;
};

struct span program_source(const char *name)
{
    return embed_shader(name);
}

static bool is_done(struct expansion *x, const char *name)
{
    for (int i = 0; i < x->done_count; i++)
        if (strcmp(x->done[i], name) == 0)
            return true;
    if (x->done_count < INCLUDES_MAX)
        snprintf(x->done[x->done_count++], sizeof x->done[0], "%s", name);
    return false;
}

// "A=1 B" -> "#define A 1\n#define B\n"
static void put_defines(struct buf *out, const char *defines)
{
    while (defines && *defines) {
        size_t n = strcspn(defines, " ");
        if (n > 0) {
            size_t name = strcspn(defines, "= ");
            buf_text(out, "#define ");
            buf_append(out, defines, name);
            if (name < n) {
                buf_byte(out, ' ');
                buf_append(out, defines + name + 1, n - name - 1);
            }
            buf_byte(out, '\n');
        }
        defines += n;
        defines += *defines == ' ';
    }
}

static bool put_file(struct expansion *x, const char *name, int depth,
                     struct error *err)
{
    if (strcmp(name, "params.glsl") == 0) {
        glsl_params_text(x->out);
        return true;
    }
    struct span text = embed_shader(name);
    if (!text.data)
        return error_set(err, "gpu", name, "no shader source named %s", name);
    if (depth > 8)
        return error_set(err, "gpu", name, "%s: includes nest too deep", name);
    const char *at = (const char *)text.data, *end = at + text.size;
    for (int line = 1; at < end; line++) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        size_t n = stop ? (size_t)(stop - at) + 1 : (size_t)(end - at);
        char inner[48];
        if (n > 10 && memcmp(at, "#include \"", 10) == 0 &&
            sscanf(at, "#include \"%47[^\"]\"", inner) == 1) {
            if (!is_done(x, inner) && !put_file(x, inner, depth + 1, err))
                return false;
            buf_printf(x->out, "#line %d\n", line + 1);
        } else {
            buf_append(x->out, at, n);
            if (n > 8 && memcmp(at, "#version", 8) == 0) {
                put_defines(x->out, x->defines);
                buf_printf(x->out, "#line %d\n", line + 1);
            }
        }
        at += n;
    }
    return true;
}

bool program_expand(struct buf *out, const char *name, const char *defines,
                    struct error *err)
{
    struct expansion x = {.out = out, .defines = defines};
    is_done(&x, name);
    return put_file(&x, name, 0, err);
}

static GLuint compile(GLenum kind, const char *name, const char *defines,
                      struct error *err)
{
    struct buf text = {0};
    GLuint shader = 0;
    if (program_expand(&text, name, defines, err)) {
        shader = gl.CreateShader(kind);
        const GLchar *source = (const GLchar *)text.data;
        const GLint size = (GLint)text.size;
        gl.ShaderSource(shader, 1, &source, &size);
        gl.CompileShader(shader);
        GLint ok = 0;
        gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
        if (!ok) {
            char log[240] = "";
            gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
            gl.DeleteShader(shader);
            shader = 0;
            error_set(err, "gpu", name, "%s does not compile: %s", name, log);
        }
    }
    buf_finish(&text);
    return shader;
}

// Links and lets go of the shaders, whatever the outcome.
static GLuint link_all(const GLuint *shaders, int count, const char *name,
                       struct error *err)
{
    GLuint program = gl.CreateProgram();
    GLint ok = 1;
    for (int i = 0; i < count; i++)
        if (shaders[i])
            gl.AttachShader(program, shaders[i]);
        else
            ok = 0; // the error is set already
    if (ok) {
        gl.LinkProgram(program);
        gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
        if (!ok) {
            char log[240] = "";
            gl.GetProgramInfoLog(program, sizeof log, NULL, log);
            error_set(err, "gpu", name, "%s does not link: %s", name, log);
        }
    }
    for (int i = 0; i < count; i++)
        gl.DeleteShader(shaders[i]);
    if (ok) {
        gl.ObjectLabel(GL_PROGRAM, program, -1, name);
        return program;
    }
    gl.DeleteProgram(program);
    return 0;
}

static bool key_of(char key[PROGRAM_POOL_KEY], const char *first,
                   const char *second, const char *defines, struct error *err)
{
    const int n = snprintf(key, PROGRAM_POOL_KEY, "%s|%s|%s", first, second,
                           defines ? defines : "");
    return n < PROGRAM_POOL_KEY ||
           error_set(err, "gpu", first, "%s: too many definitions", first);
}

// second: "" for a compute program, else the fragment shader's source.
static unsigned build(const char *first, const char *second,
                      const char *defines, struct error *err)
{
    if (!*second) {
        GLuint shader = compile(GL_COMPUTE_SHADER, first, defines, err);
        return link_all(&shader, 1, first, err);
    }
    GLuint shaders[2] = {compile(GL_VERTEX_SHADER, first, defines, err), 0};
    if (shaders[0])
        shaders[1] = compile(GL_FRAGMENT_SHADER, second, defines, err);
    return link_all(shaders, 2, first, err);
}

static unsigned take_or_build(const char *first, const char *second,
                              const char *defines, struct error *err)
{
    char key[PROGRAM_POOL_KEY];
    if (!key_of(key, first, second, defines, err))
        return 0;
    unsigned program = program_pool_take(key);
    if (!program && (program = build(first, second, defines, err)))
        program_pool_add(key, program, true);
    return program;
}

unsigned program_compute(const char *name, const char *defines,
                         struct error *err)
{
    return take_or_build(name, "", defines, err);
}

unsigned program_raster(const char *vert, const char *frag, const char *defines,
                        struct error *err)
{
    return take_or_build(vert, frag, defines, err);
}

void program_drop(unsigned program)
{
    program_pool_give(program);
}

bool program_prepare(struct span line, struct error *err)
{
    char key[PROGRAM_POOL_KEY], part[PROGRAM_POOL_KEY];
    if (line.size >= sizeof key)
        return error_set(err, "gpu", "program", "a program's name is too long");
    memcpy(key, line.data, line.size);
    key[line.size] = 0;
    if (program_pool_has(key))
        return true;
    memcpy(part, key, sizeof part);
    char *second = strchr(part, '|');
    char *defines = second ? strchr(second + 1, '|') : NULL;
    if (!defines)
        return error_set(err, "gpu", key, "%s: no program's name", key);
    *second++ = *defines++ = 0;
    const unsigned program = build(part, second, defines, err);
    if (program)
        program_pool_add(key, program, false);
    return program != 0;
}

void program_use(unsigned program)
{
    const unsigned neutral = program_pool_neutral();
    if (neutral) {
        gl.UseProgram(neutral);
        gl.DispatchCompute(1, 1, 1);
    }
    gl.UseProgram(program);
}
