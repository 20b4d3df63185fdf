// gl_count.c - each of these counts, then calls the driver.  A few nanoseconds
// a call, of some hundred calls a frame.
#include "renderer/gl_count.h"

#include "renderer/gl.h"

static struct gl real;
static _Thread_local struct gl_counts counts;

struct gl_counts gl_count_now(void)
{
    return counts;
}

struct gl_counts gl_count_since(const struct gl_counts *from)
{
    return (struct gl_counts){
        .dispatches = counts.dispatches - from->dispatches,
        .draws = counts.draws - from->draws,
        .uploads = counts.uploads - from->uploads,
        .upload_bytes = counts.upload_bytes - from->upload_bytes,
        .reads = counts.reads - from->reads,
        .read_bytes = counts.read_bytes - from->read_bytes,
        .allocations = counts.allocations - from->allocations,
        .programs = counts.programs - from->programs,
    };
}

static void upload(uint64_t bytes)
{
    counts.uploads++;
    counts.upload_bytes += bytes;
}

static void APIENTRY dispatch(GLuint x, GLuint y, GLuint z)
{
    counts.dispatches++;
    real.DispatchCompute(x, y, z);
}

static void APIENTRY dispatch_indirect(GLintptr at)
{
    counts.dispatches++;
    real.DispatchComputeIndirect(at);
}

static void APIENTRY draw_arrays(GLenum mode, GLint first, GLsizei n)
{
    counts.draws++;
    real.DrawArrays(mode, first, n);
}

static void APIENTRY draw_elements(GLenum mode, GLsizei n, GLenum type,
                                   const void *index, GLint base)
{
    counts.draws++;
    real.DrawElementsBaseVertex(mode, n, type, index, base);
}

static void APIENTRY buffer_storage(GLuint b, GLsizeiptr size, const void *data,
                                    GLbitfield flags)
{
    counts.allocations++;
    if (data)
        upload((uint64_t)size);
    real.NamedBufferStorage(b, size, data, flags);
}

static void APIENTRY buffer_data(GLuint b, GLintptr at, GLsizeiptr size,
                                 const void *data)
{
    upload((uint64_t)size);
    real.NamedBufferSubData(b, at, size, data);
}

static void APIENTRY buffer_read(GLuint b, GLintptr at, GLsizeiptr size,
                                 void *data)
{
    counts.reads++;
    counts.read_bytes += (uint64_t)size;
    real.GetNamedBufferSubData(b, at, size, data);
}

static void APIENTRY storage_2d(GLuint t, GLsizei levels, GLenum format,
                                GLsizei w, GLsizei h)
{
    counts.allocations++;
    real.TextureStorage2D(t, levels, format, w, h);
}

static void APIENTRY storage_3d(GLuint t, GLsizei levels, GLenum format,
                                GLsizei w, GLsizei h, GLsizei d)
{
    counts.allocations++;
    real.TextureStorage3D(t, levels, format, w, h, d);
}

// Of a pixel as the caller has it.
static uint64_t pixel_bytes(GLenum format, GLenum type)
{
    const uint64_t each =
        type == GL_UNSIGNED_BYTE || type == GL_BYTE ? 1
        : type == GL_HALF_FLOAT || type == GL_UNSIGNED_SHORT || type == GL_SHORT
            ? 2
            : 4;
    switch (format) {
    case GL_RG:
    case GL_RG_INTEGER:
        return 2 * each;
    case GL_RGB:
    case GL_RGB_INTEGER:
        return 3 * each;
    case GL_RGBA:
    case GL_RGBA_INTEGER:
        return 4 * each;
    default:
        return each;
    }
}

static void APIENTRY image_2d(GLuint t, GLint level, GLint x, GLint y,
                              GLsizei w, GLsizei h, GLenum format, GLenum type,
                              const void *data)
{
    upload((uint64_t)w * (uint64_t)h * pixel_bytes(format, type));
    real.TextureSubImage2D(t, level, x, y, w, h, format, type, data);
}

static void APIENTRY image_3d(GLuint t, GLint level, GLint x, GLint y, GLint z,
                              GLsizei w, GLsizei h, GLsizei d, GLenum format,
                              GLenum type, const void *data)
{
    upload((uint64_t)w * (uint64_t)h * (uint64_t)d * pixel_bytes(format, type));
    real.TextureSubImage3D(t, level, x, y, z, w, h, d, format, type, data);
}

static void APIENTRY link_program(GLuint p)
{
    counts.programs++;
    real.LinkProgram(p);
}

// `driver` is the same on every call, so that it may be written while another
// thread calls.
void gl_count_install(struct gl *table, const struct gl *driver)
{
    struct gl counting = *driver;
    counting.DispatchCompute = dispatch;
    counting.DispatchComputeIndirect = dispatch_indirect;
    counting.DrawArrays = draw_arrays;
    counting.DrawElementsBaseVertex = draw_elements;
    counting.NamedBufferStorage = buffer_storage;
    counting.NamedBufferSubData = buffer_data;
    counting.GetNamedBufferSubData = buffer_read;
    counting.TextureStorage2D = storage_2d;
    counting.TextureStorage3D = storage_3d;
    counting.TextureSubImage2D = image_2d;
    counting.TextureSubImage3D = image_3d;
    counting.LinkProgram = link_program;
    real = *driver;
    *table = counting;
}
