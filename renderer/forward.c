// forward.c - targets, programs and passes of forward shading.  What light a
// place sends is shade.glsl's affair, where strands are, visible.vert's.
#include "renderer/forward.h"

#include <stdio.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/program.h"

enum {
    LIGHTS_A_PASS = 16, // Xu 2011, section 5
    ID_UNIT = 14,       // fragment.glsl
    COLOUR_UNIT = 15,   // forward_add.comp
    LIGHTS_LOCATION = 17
};

// --- life --------------------------------------------------------------------

void forward_drop(struct forward *f)
{
    gl.DeleteTextures(1, &f->colour);
    gl.DeleteFramebuffers(2, f->target);
    for (int i = 0; i < 2; i++)
        picture_gl_drop(&f->seen[i]);
    f->colour = f->target[0] = f->target[1] = 0;
    f->width = f->height = 0;
    f->bytes = 0;
    forward_forget(f);
}

void forward_finish(struct forward *f)
{
    forward_drop(f);
    for (int i = 0; i < FORWARD_VARIANTS; i++) {
        program_drop(f->variant[i].thin);
        program_drop(f->variant[i].wide);
    }
    program_drop(f->number);
    program_drop(f->add);
    memset(f, 0, sizeof *f);
}

void forward_forget(struct forward *f)
{
    f->first_kept = false;
    f->listed = -1;
}

static bool framebuffer(unsigned *out, unsigned colour, unsigned depth)
{
    gl.CreateFramebuffers(1, out);
    gl.NamedFramebufferTexture(*out, GL_COLOR_ATTACHMENT0, colour, 0);
    gl.NamedFramebufferTexture(*out, GL_DEPTH_ATTACHMENT, depth, 0);
    return gl.CheckNamedFramebufferStatus(*out, GL_FRAMEBUFFER) ==
           GL_FRAMEBUFFER_COMPLETE;
}

// Targets of the picture's size, and the programs that need no variant.
static bool fit(struct forward *f, const struct picture *p, struct error *err)
{
    if (!f->number)
        f->number = program_compute("forward_number.comp", NULL, err);
    if (!f->add)
        f->add = program_compute("forward_add.comp", NULL, err);
    if (!f->number || !f->add)
        return false;
    if (f->width == p->width && f->height == p->height)
        return true;
    forward_drop(f);
    f->width = p->width;
    f->height = p->height;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &f->colour);
    gl.TextureStorage2D(f->colour, 1, GL_RGBA32F, f->width, f->height);
    f->bytes = (uint64_t)(16 + 2 * PICTURE_GL_PIXEL) * (uint64_t)f->width *
               (uint64_t)f->height;
    if (picture_gl_target(&f->seen[0], f->width, f->height, err) &&
        picture_gl_target(&f->seen[1], f->width, f->height, err) &&
        framebuffer(&f->target[0], f->colour, f->seen[0].depth) &&
        framebuffer(&f->target[1], f->colour, f->seen[1].depth) &&
        gl_check("forward targets", err))
        return true;
    forward_drop(f);
    return error_set(err, "gpu", "render.path",
                     "the driver cannot add up light in a %d x %d picture",
                     p->width, p->height);
}

// --- what is seen ------------------------------------------------------------

bool forward_must_see(const struct forward *f, const struct picture *p, int k)
{
    const bool fits = f->width == p->width && f->height == p->height;
    return k > 0 || !fits || !f->first_kept;
}

bool forward_see(struct forward *f, struct picture *p, const struct strands *s,
                 int k, struct error *err)
{
    if (!fit(f, p, err))
        return false;
    f->listed = -1;
    if (!picture_gl_raster(&p->drawn, s, &f->seen[k > 0], err))
        return false;
    f->first_kept |= k == 0;
    return true;
}

void forward_bind(const struct forward *f, const struct picture *p, int k)
{
    const GLfloat nothing[4] = {0, 0, 0, 0};
    gl.ClearNamedFramebufferfv(f->target[k > 0], GL_COLOR, 0, nothing);
    picture_bind(p);
    gl.BindTextureUnit(ID_UNIT, f->seen[k > 0].id);
}

bool forward_list(struct forward *f, struct picture *p, int k)
{
    if (f->listed == k)
        return false;
    picture_list(p, k);
    gl.UseProgram(f->number);
    gl.DispatchCompute((GLuint)(p->width + 7) / 8, (GLuint)(p->height + 7) / 8,
                       1);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    f->listed = k;
    return true;
}

// --- passes ------------------------------------------------------------------

// The programs of these defines, where they are kept or in the oldest's place.
static struct forward_variant *variant_of(struct forward *f,
                                          const char *defines)
{
    struct forward_variant *v = &f->variant[0];
    for (int i = 0; i < FORWARD_VARIANTS; i++) {
        if (strcmp(f->variant[i].defines, defines) == 0) {
            v = &f->variant[i];
            break;
        }
        if (f->variant[i].age < v->age)
            v = &f->variant[i];
    }
    if (strcmp(v->defines, defines) != 0) {
        program_drop(v->thin);
        program_drop(v->wide);
        memset(v, 0, sizeof *v);
        snprintf(v->defines, sizeof v->defines, "%s", defines);
    }
    v->age = ++f->clock;
    return v;
}

static bool compile(struct forward_variant *v, const struct strands *s,
                    struct error *err)
{
    char wide[FORWARD_DEFINES + 8];
    snprintf(wide, sizeof wide, "WIDE %s", v->defines);
    if (s->draw_thin && !v->thin)
        v->thin =
            program_raster("visible.vert", "forward.frag", v->defines, err);
    if (s->draw_wide && !v->wide)
        v->wide = program_raster("visible.vert", "forward.frag", wide, err);
    return (!s->draw_thin || v->thin) && (!s->draw_wide || v->wide);
}

static void pass_over(const struct forward_pass *q,
                      const struct forward_variant *v, int first, int end)
{
    const unsigned programs[2] = {v->thin, v->wide};
    for (int i = 0; i < 2; i++)
        if (programs[i])
            gl.ProgramUniform2ui(programs[i], LIGHTS_LOCATION, (GLuint)first,
                                 (GLuint)end);
    picture_gl_draw(&q->picture->drawn, q->strands, v->thin, v->wide);
}

bool forward_shade(struct forward *f, const struct forward_pass *q, int k,
                   struct error *err)
{
    char defines[FORWARD_DEFINES];
    shading_defines(q->shading, q->nodes, defines);
    if (q->strands->opacity)
        strcat(defines, " WITH_OPACITY");
    if (f->centres)
        strcat(defines, " CENTRES");
    struct forward_variant *v = variant_of(f, defines);
    if (!compile(v, q->strands, err))
        return false;
    const unsigned programs[2] = {v->thin, v->wide};
    for (int i = 0; i < 2; i++)
        if (programs[i])
            shading_bind_inputs(q->shading, programs[i], q->strands, q->nodes);
    const unsigned target = f->target[k > 0];
    gl.BindFramebuffer(GL_FRAMEBUFFER, target);
    gl.Viewport(0, 0, f->width, f->height);
    gl.DepthMask(GL_FALSE);
    gl.DepthFunc(GL_EQUAL);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
    int step = f->lights_a_pass > 0 ? f->lights_a_pass : LIGHTS_A_PASS;
    if (!q->shading->adds_up || step > q->lights)
        step = q->lights > 0 ? q->lights : 1;
    int first = 0;
    do { // one pass even without a light: it says where hair is
        int end = first + step < q->lights ? first + step : q->lights;
        pass_over(q, v, first, end);
        first += step;
    } while (first < q->lights);
    gl.Disable(GL_BLEND);
    gl.DepthMask(GL_TRUE);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.TextureBarrier(); // as in picture_gl_raster
    return true;
}

void forward_add(const struct forward *f, const struct picture *p)
{
    gl.BindTextureUnit(COLOUR_UNIT, f->colour);
    gl.UseProgram(f->add);
    gl_dispatch((uint64_t)p->width * (uint64_t)p->height);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT |
                     GL_BUFFER_UPDATE_BARRIER_BIT);
}
