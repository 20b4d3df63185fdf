// gl.c - the function table, filled once a context is current.
#include "renderer/gl.h"

#include <stdatomic.h>
#include <string.h>

#include <EGL/egl.h>

#include "renderer/gl_count.h"

struct gl gl;

// ISO C has no cast between object and function pointers; POSIX guarantees
// that copying the bits works.
static bool fetch(void *slot, const char *name)
{
    void (*function)(void) = eglGetProcAddress(name);
    memcpy(slot, &function, sizeof function);
    return function != NULL;
}

bool gl_load(struct error *err)
{
    static atomic_bool loaded; // contexts come from one driver
    struct gl driver;
    if (atomic_load(&loaded))
        return true;
#define F(UPPER, Name) \
    if (!fetch(&driver.Name, "gl" #Name)) \
        return error_set(err, "gpu", "gl" #Name, \
                         "the OpenGL driver has no gl" #Name \
                         " (OpenGL 4.5 core is needed)");
    GL_FUNCTIONS(F)
#undef F
    gl_count_install(&gl, &driver);
    atomic_store(&loaded, true);
    return true;
}

bool gl_check(const char *doing, struct error *err)
{
    GLenum code = gl.GetError();
    if (code == GL_NO_ERROR)
        return true;
    for (int i = 0; i < 16 && gl.GetError() != GL_NO_ERROR; i++) {
    }
    const char *what = code == GL_OUT_OF_MEMORY  ? "out of GPU memory"
                       : code == GL_CONTEXT_LOST ? "the GPU context was lost"
                                                 : "OpenGL error";
    return error_set(err, "gpu", doing, "%s: %s (0x%04x)", doing, what, code);
}

unsigned gl_buffer(uint64_t bytes, const void *data, const char *name)
{
    GLuint b = 0;
    gl.CreateBuffers(1, &b);
    gl.NamedBufferStorage(b, (GLsizeiptr)bytes, data,
                          data ? 0 : GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, b, -1, name);
    return b;
}

uint64_t gl_texture_buffer_size(uint64_t n)
{
    while ((n >> 8 & 0xff) == 0 || (n & (n - 1)) == 0)
        n += 256;
    return n;
}

int gl_texture_side(int n)
{
    while ((n & (n - 1)) == 0)
        n++;
    return n;
}

void gl_dispatch(uint64_t n)
{
    const uint64_t groups = (n + 63) / 64;
    const uint64_t rows = (groups + GL_ROW_GROUPS - 1) / GL_ROW_GROUPS;
    gl.DispatchCompute(
        (GLuint)(groups < GL_ROW_GROUPS ? groups : GL_ROW_GROUPS), (GLuint)rows,
        1);
}

void gl_dispatch_spread(uint64_t pieces)
{
    const uint64_t n = (pieces + GL_SPREAD - 1) / GL_SPREAD * GL_SPREAD;
    gl_dispatch(64 * n);
}
