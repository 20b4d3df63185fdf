// gl.h - the OpenGL functions in use, each fetched by eglGetProcAddress: no
// libGL is linked.  Called as gl.DispatchCompute(...).
// Thread: the one whose EGL context is current.
#ifndef RENDERER_GL_H
#define RENDERER_GL_H

#include <stdbool.h>
#include <stdint.h>

#include <GL/glcorearb.h>

#include "protocol/error.h"

// clang-format off
#define GL_FUNCTIONS(F)                                                        \
    F(GETSTRING, GetString)                                                    \
    F(GETINTEGERV, GetIntegerv)                                                \
    F(GETINTEGER64V, GetInteger64v)                                            \
    F(GETERROR, GetError)                                                      \
    F(ENABLE, Enable)                                                          \
    F(DISABLE, Disable)                                                        \
    F(VIEWPORT, Viewport)                                                      \
    F(COLORMASK, ColorMask)                                                    \
    F(DEPTHMASK, DepthMask)                                                    \
    F(DEPTHFUNC, DepthFunc)                                                    \
    F(BLENDFUNC, BlendFunc)                                                    \
    F(CLIPCONTROL, ClipControl)                                                \
    F(FINISH, Finish)                                                          \
    F(FLUSH, Flush)                                                            \
    F(DEBUGMESSAGECALLBACK, DebugMessageCallback)                              \
    F(OBJECTLABEL, ObjectLabel)                                                \
    F(PUSHDEBUGGROUP, PushDebugGroup)                                          \
    F(POPDEBUGGROUP, PopDebugGroup)                                            \
    F(CREATESHADER, CreateShader)                                              \
    F(SHADERSOURCE, ShaderSource)                                              \
    F(COMPILESHADER, CompileShader)                                            \
    F(GETSHADERIV, GetShaderiv)                                                \
    F(GETSHADERINFOLOG, GetShaderInfoLog)                                      \
    F(DELETESHADER, DeleteShader)                                              \
    F(CREATEPROGRAM, CreateProgram)                                            \
    F(ATTACHSHADER, AttachShader)                                              \
    F(LINKPROGRAM, LinkProgram)                                                \
    F(GETPROGRAMIV, GetProgramiv)                                              \
    F(GETPROGRAMINFOLOG, GetProgramInfoLog)                                    \
    F(DELETEPROGRAM, DeleteProgram)                                            \
    F(USEPROGRAM, UseProgram)                                                  \
    F(GETUNIFORMLOCATION, GetUniformLocation)                                  \
    F(PROGRAMUNIFORM1I, ProgramUniform1i)                                      \
    F(PROGRAMUNIFORM1UI, ProgramUniform1ui)                                    \
    F(PROGRAMUNIFORM1F, ProgramUniform1f)                                      \
    F(PROGRAMUNIFORM2F, ProgramUniform2f)                                      \
    F(PROGRAMUNIFORM3F, ProgramUniform3f)                                      \
    F(PROGRAMUNIFORM4F, ProgramUniform4f)                                      \
    F(PROGRAMUNIFORM2UI, ProgramUniform2ui)                                    \
    F(PROGRAMUNIFORM3UI, ProgramUniform3ui)                                    \
    F(PROGRAMUNIFORM4UI, ProgramUniform4ui)                                    \
    F(CREATEBUFFERS, CreateBuffers)                                            \
    F(NAMEDBUFFERSTORAGE, NamedBufferStorage)                                  \
    F(NAMEDBUFFERSUBDATA, NamedBufferSubData)                                  \
    F(GETNAMEDBUFFERSUBDATA, GetNamedBufferSubData)                            \
    F(CLEARNAMEDBUFFERDATA, ClearNamedBufferData)                              \
    F(CLEARNAMEDBUFFERSUBDATA, ClearNamedBufferSubData)                        \
    F(MAPNAMEDBUFFERRANGE, MapNamedBufferRange)                                \
    F(UNMAPNAMEDBUFFER, UnmapNamedBuffer)                                      \
    F(DELETEBUFFERS, DeleteBuffers)                                            \
    F(BINDBUFFER, BindBuffer)                                                  \
    F(BINDBUFFERBASE, BindBufferBase)                                          \
    F(BINDBUFFERRANGE, BindBufferRange)                                        \
    F(CREATETEXTURES, CreateTextures)                                          \
    F(TEXTURESTORAGE2D, TextureStorage2D)                                      \
    F(TEXTURESUBIMAGE2D, TextureSubImage2D)                                    \
    F(TEXTURESTORAGE3D, TextureStorage3D)                                      \
    F(TEXTUREBUFFER, TextureBuffer)                                            \
    F(TEXTURESUBIMAGE3D, TextureSubImage3D)                                    \
    F(TEXTUREPARAMETERI, TextureParameteri)                                    \
    F(GETTEXTUREIMAGE, GetTextureImage)                                        \
    F(GETTEXTURESUBIMAGE, GetTextureSubImage)                                  \
    F(CLEARTEXIMAGE, ClearTexImage)                                            \
    F(DELETETEXTURES, DeleteTextures)                                          \
    F(BINDTEXTUREUNIT, BindTextureUnit)                                        \
    F(BINDIMAGETEXTURE, BindImageTexture)                                      \
    F(PIXELSTOREI, PixelStorei)                                                \
    F(CREATEFRAMEBUFFERS, CreateFramebuffers)                                  \
    F(NAMEDFRAMEBUFFERTEXTURE, NamedFramebufferTexture)                        \
    F(CHECKNAMEDFRAMEBUFFERSTATUS, CheckNamedFramebufferStatus)                \
    F(DELETEFRAMEBUFFERS, DeleteFramebuffers)                                  \
    F(BINDFRAMEBUFFER, BindFramebuffer)                                        \
    F(CLEARNAMEDFRAMEBUFFERUIV, ClearNamedFramebufferuiv)                      \
    F(CLEARNAMEDFRAMEBUFFERFV, ClearNamedFramebufferfv)                        \
    F(CREATEVERTEXARRAYS, CreateVertexArrays)                                  \
    F(DELETEVERTEXARRAYS, DeleteVertexArrays)                                  \
    F(BINDVERTEXARRAY, BindVertexArray)                                        \
    F(DRAWARRAYS, DrawArrays)                                                  \
    F(DRAWELEMENTSBASEVERTEX, DrawElementsBaseVertex)                          \
    F(VERTEXARRAYELEMENTBUFFER, VertexArrayElementBuffer)                      \
    F(DISPATCHCOMPUTE, DispatchCompute)                                        \
    F(DISPATCHCOMPUTEINDIRECT, DispatchComputeIndirect)                        \
    F(MEMORYBARRIER, MemoryBarrier)                                            \
    F(TEXTUREBARRIER, TextureBarrier)                                          \
    F(FENCESYNC, FenceSync)                                                    \
    F(CLIENTWAITSYNC, ClientWaitSync)                                          \
    F(DELETESYNC, DeleteSync)                                                  \
    F(CREATEQUERIES, CreateQueries)                                            \
    F(DELETEQUERIES, DeleteQueries)                                            \
    F(QUERYCOUNTER, QueryCounter)                                              \
    F(GETQUERYOBJECTUI64V, GetQueryObjectui64v)
// clang-format on

struct gl {
#define F(UPPER, Name) PFNGL##UPPER##PROC Name;
    GL_FUNCTIONS(F)
#undef F
};
extern struct gl gl;

// Fetches every function; false names the first one missing.  Those that ask
// for work or memory count (gl_count.h).
bool gl_load(struct error *err);

// The first pending GL error as an error that names `doing`; true when none.
bool gl_check(const char *doing, struct error *err);

// A new buffer of so many bytes, named for debuggers.  data: its bytes, which
// then stay; NULL: glNamedBufferSubData may write it.
unsigned gl_buffer(uint64_t bytes, const void *data, const char *name);

// Runs the program in use for n invocations in groups of 64, in rows, for GL
// promises no more than 65535 groups along an axis.  A shader's number is
// gl_GlobalInvocationID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x * 64.
enum { GL_ROW_GROUPS = 32768 }; // count.comp has it too
void gl_dispatch(uint64_t n);
// As many groups of 64 as there are pieces, or a few more
// (shaders/spread.glsl).
enum { GL_SPREAD = 8 };
void gl_dispatch_spread(uint64_t pieces);
// At least n, for a buffer that a texture looks into.  Mesa's llvmpipe makes
// machine code once more where such a size is a power of two, or where its bits
// 8 to 15 are zero (which it takes for a count of mip levels): none is ever so.
uint64_t gl_texture_buffer_size(uint64_t n);
// As well for the side of a texture that depends on the scene or on a choice:
// the least from n > 0 on that is no power of two.
int gl_texture_side(int n);

#endif
