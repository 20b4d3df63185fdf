// embed.h - the shader sources that the build puts into the binary.
// Thread: any (constants).
#ifndef RENDERER_EMBED_H
#define RENDERER_EMBED_H

#include "protocol/bytes.h"

// The text of shaders/NAME; an empty span when there is no such file.
struct span embed_shader(const char *name);

#endif
