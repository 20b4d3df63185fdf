// egl.h - an OpenGL 4.5 core context without a display.
// Thread: the one that creates it owns it until destroy; current on return.
#ifndef RENDERER_EGL_H
#define RENDERER_EGL_H

#include <stdbool.h>

#include "protocol/error.h"

struct egl;

// Tries each EGL device, then the surfaceless platform.  Loads gl.h's function
// table.  With GLINT_GL_DEBUG=1 in the environment the context reports GL
// errors on stderr.
struct egl *egl_create(struct error *err);
void egl_destroy(struct egl *e); // NULL is allowed
// Makes it the thread's current context again, where another one came between.
void egl_use(const struct egl *e);
const char *egl_device(const struct egl *e); // "vendor, renderer, version"

#endif
