// egl.c - finds a way to a GL context without a display: every EGL device in
// turn, then Mesa's surfaceless platform.  What is drawn is others' affair.
#include "renderer/egl.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program_pool.h"

// Displays belong to the process, not to a context: the last one out closes.
static atomic_int users;

struct egl {
    EGLDisplay display;
    EGLContext context;
    struct program_pool *programs;
    char device[256];
};

static EGLDisplay display_of(EGLenum platform, void *native)
{
    EGLDisplay d = eglGetPlatformDisplay(platform, native, NULL);
    if (d != EGL_NO_DISPLAY && !eglInitialize(d, NULL, NULL))
        return EGL_NO_DISPLAY;
    return d;
}

static bool context_on(struct egl *e, EGLDisplay display)
{
    if (display == EGL_NO_DISPLAY || !eglBindAPI(EGL_OPENGL_API))
        return false;
    const EGLint debug = getenv("GLINT_GL_DEBUG") ? EGL_TRUE : EGL_FALSE;
    const EGLint want[] = {EGL_CONTEXT_MAJOR_VERSION,
                           4,
                           EGL_CONTEXT_MINOR_VERSION,
                           5,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_CONTEXT_OPENGL_DEBUG,
                           debug,
                           EGL_NONE};
    EGLContext c =
        eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, want);
    if (c == EGL_NO_CONTEXT)
        return false;
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, c)) {
        eglDestroyContext(display, c);
        return false;
    }
    e->display = display;
    e->context = c;
    return true;
}

static bool any_device(struct egl *e)
{
    PFNEGLQUERYDEVICESEXTPROC query =
        (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (!query || !query(16, devices, &count))
        return false;
    for (EGLint i = 0; i < count; i++)
        if (context_on(e, display_of(EGL_PLATFORM_DEVICE_EXT, devices[i])))
            return true;
    return false;
}

static void APIENTRY report(GLenum source, GLenum type, GLuint id,
                            GLenum severity, GLsizei length,
                            const GLchar *message, const void *user)
{
    (void)source, (void)type, (void)id, (void)length, (void)user;
    if (severity != GL_DEBUG_SEVERITY_NOTIFICATION)
        fprintf(stderr, "gl: %s\n", message);
}

static const char *gl_text(GLenum name)
{
    const GLubyte *s = gl.GetString(name);
    return s ? (const char *)s : "?";
}

struct egl *egl_create(struct error *err)
{
    struct egl *e = bytes_zalloc(1, sizeof *e);
    atomic_fetch_add(&users, 1);
    if (!any_device(e) &&
        !context_on(e, display_of(EGL_PLATFORM_SURFACELESS_MESA,
                                  EGL_DEFAULT_DISPLAY))) {
        error_set(err, "gpu", "egl",
                  "no EGL device gives an OpenGL 4.5 core context (last EGL "
                  "error 0x%04x); is a driver installed (Debian: "
                  "libgl1-mesa-dri)?",
                  (unsigned)eglGetError());
        goto fail;
    }
    if (!gl_load(err))
        goto fail;
    e->programs = program_pool_create();
    program_pool_use(e->programs);
    if (getenv("GLINT_GL_DEBUG")) {
        gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        gl.DebugMessageCallback(report, NULL);
    }
    snprintf(e->device, sizeof e->device, "%s, %s, %s", gl_text(GL_VENDOR),
             gl_text(GL_RENDERER), gl_text(GL_VERSION));
    return e;
fail:
    egl_destroy(e);
    return NULL;
}

void egl_destroy(struct egl *e)
{
    if (!e)
        return;
    if (e->context) {
        egl_use(e);
        program_pool_destroy(e->programs);
        if (eglGetCurrentContext() == e->context)
            eglMakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                           EGL_NO_CONTEXT);
        eglDestroyContext(e->display, e->context);
    }
    bool last = atomic_fetch_sub(&users, 1) == 1 && e->display;
#ifdef GLINT_SANITIZED
    last = false; // else the driver is unmapped and its leaks lose their name
#endif
    if (last)
        eglTerminate(e->display);
    free(e);
}

void egl_use(const struct egl *e)
{
    program_pool_use(e->programs);
    if (eglGetCurrentContext() != e->context)
        eglMakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE, e->context);
}

const char *egl_device(const struct egl *e)
{
    return e->device;
}
