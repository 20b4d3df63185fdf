// shading.c - chooses what a scene needs of the fibre's scattering.
#include "renderer/shading.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "renderer/gl.h"
#include "renderer/glsl.h"
#include "renderer/lights.h"
#include "renderer/program.h"

// Up to FIXED_M segments the count is a constant of the program; above it is
// the uniform of shaders/xu.glsl, since unrolling would gain nothing.
enum {
    PARAMS_ROWS_MAX = 128,
    FIXED_M = 8,
    // of render.components: all, R, TT, TRT, single, global, local, views
    LAST_SINGLE = 4,
    LAST_LIGHT = 6,
    PART_LOCATION = 0,
    FROM_LOCATION = 5,
    XU_M_LOCATION = 16 // xu.glsl
};

#define MARK "LIT_MARK" // the word of programs that mark

void shading_init(struct shading *s)
{
    memset(s, 0, sizeof *s);
    gl.CreateBuffers(1, &s->params);
    gl.NamedBufferStorage(s->params, 16 * params_row_count, NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, s->params, -1, "parameters");
}

void shading_finish(struct shading *s)
{
    for (int i = 0; i < SHADING_VARIANTS; i++)
        program_drop(s->variant[i].program);
    gl.DeleteBuffers(1, &s->params);
    xu_tables_destroy(s->tables);
    best_lobes_destroy(s->lobes);
    dual_tables_destroy(s->dual);
    fast_tables_destroy(s->fast);
    lit_tables_destroy(s->lit);
    memset(s, 0, sizeof *s);
}

// Upper bound of what TT and TRT together can add, relative to R at normal
// incidence.  Their internal path is at least 2 cos(gamma_t) >= 2 sqrt(1 -
// 1/eta^2) radii per segment, with the smallest absorption of the three
// channels (Xu 2011, eq 10); the fourth-order series of scheme `paper` (eq 18)
// exceeds the exact attenuation by its own largest value, so both are taken.
static double opaque_bound(const struct params *p)
{
    double eta = p->fibre.eta, a2 = p->fibre.a * p->fibre.a;
    double s = fmin(p->fibre.sigma_a[0],
                    fmin(p->fibre.sigma_a[1], p->fibre.sigma_a[2]));
    double spread = fmax(a2, 1 / a2); // smallest eta*, Xu 2011, eq 24
    double least = 2 * (eta - 1) / spread - eta + 2;
    double low = fmax(fmin(eta, least), 1.0);
    double exact = exp(-2 * s * sqrt(1 - 1 / (low * low)));
    double series = exp(-2 * s) * (1 + s + (s / 4 + s * s / 2));
    double f0 = pow((eta - 1) / (eta + 1), 2);
    return fmax(exact, series) / f0;
}

static void add(char *defines, const char *word)
{
    size_t n = strlen(defines);
    snprintf(defines + n, SHADING_DEFINES - n, "%s%s", n ? " " : "", word);
}

// The words of render.components that show something else than light.
static const char *view_of(int components)
{
    static const char *const views[] = {"VIEW_FIELD=0", "VIEW_FIELD=1",
                                        "VIEW_TANGENT", "VIEW_COVERAGE",
                                        "VIEW_STRAND"};
    return components > LAST_LIGHT ? views[components - LAST_LIGHT - 1] : NULL;
}

// Does anything read the tables of scheme `paper`?
static bool wants_tables(const struct shading *s, const struct params *p)
{
    return (p->render.scheme == 0 && !s->tabled) ||
           (s->multiple && p->render.multiple == 1);
}

static void name_base(struct shading *s, const struct params *p,
                      const struct strands *strands, int shown)
{
    const double negligible = 1e-4; // of R: below one 8-bit step by far
    const char *view = view_of(shown);
    char m[16];
    s->circular = !shading_wants_axis(p);
    s->opaque_bound = opaque_bound(p);
    s->opaque = s->opaque_bound < negligible;
    // segments are the paper's affair
    bool paper = wants_tables(s, p);
    s->m = paper && p->render.m > FIXED_M ? p->render.m : 0;
    s->base[0] = 0;
    snprintf(m, sizeof m, "XU_M=%d", p->render.m);
    if (paper && !s->m)
        add(s->base, m);
    if (paper && p->render.nodes == 1)
        add(s->base, "XU_FINE_NODES");
    if (s->best)
        add(s->base, "XU_BEST");
    if (!s->circular)
        add(s->base, "XU_ECCENTRIC");
    if (s->tabled)
        add(s->base, "FAST");
    if (s->opaque)
        add(s->base, "XU_NO_TT_TRT");
    if (strands->colour)
        add(s->base, "WITH_COLOUR");
    if (s->shadowed)
        add(s->base,
            p->shadow.method == 2 ? "WITH_SHADOW SHADOW_MAP" : "WITH_SHADOW");
    if (!view && shown <= LAST_SINGLE)
        add(s->base, "WITH_SINGLE");
    if (s->multiple)
        add(s->base, p->render.multiple == 1 ? "WITH_MULTIPLE DUAL_PAPER"
                                             : "WITH_MULTIPLE");
    if (view)
        add(s->base, view);
}

bool shading_wants_axis(const struct params *p)
{
    return p->fibre.a != 1.0f;
}

static void choose_components(struct shading *s, int shown)
{
    for (int i = 0; i < 3; i++)
        s->mask[i] = shown == 0 || shown == LAST_SINGLE || shown == i + 1;
    s->share[0] = shown == 0 || shown == LAST_SINGLE + 1;
    s->share[1] = shown == 0 || shown == LAST_SINGLE + 2;
    s->adds_up = shown <= LAST_LIGHT;
    s->whole = shown == 0;
}

bool shading_adds_up(const struct params *p)
{
    return p->render.components <= LAST_LIGHT;
}

static void update_lobes(struct shading *s, const struct params *p)
{
    const struct best_fibre f = {
        .eta = p->fibre.eta,
        .sigma_a = {p->fibre.sigma_a[0], p->fibre.sigma_a[1],
                    p->fibre.sigma_a[2]},
        .a = p->fibre.a,
        .w_c = p->fibre.w_c * M_PI / 180,
    };
    if (!s->lobes)
        s->lobes = best_lobes_create();
    best_lobes_update(s->lobes, &f);
}

static struct dual_fibre fibre_of(const struct params *p)
{
    struct params r = *p;
    params_fibre_resolve(&r);
    const double rad = M_PI / 180;
    return (struct dual_fibre){
        .eta = r.fibre.eta,
        .sigma_a = {r.fibre.sigma_a[0], r.fibre.sigma_a[1], r.fibre.sigma_a[2]},
        .a = r.fibre.a,
        .alpha = {r.fibre.alpha_r * rad, r.fibre.alpha_tt * rad,
                  r.fibre.alpha_trt * rad},
        .beta = {r.fibre.beta_r * rad, r.fibre.beta_tt * rad,
                 r.fibre.beta_trt * rad},
        .w_c = r.fibre.w_c * rad,
        .delta_eta = r.fibre.delta_eta,
    };
}

static void update_dual(struct shading *s, const struct params *p)
{
    const struct dual_fibre f = fibre_of(p);
    if (!s->dual)
        s->dual = dual_tables_create();
    dual_tables_update(s->dual, &f,
                       p->render.multiple == 1 ? DUAL_SCHEME_PAPER
                                               : DUAL_SCHEME_BEST);
}

// Do tables light this scene?  They know the paper's formulas neither of single
// nor of multiple scattering: who asks for those gets them.
static void choose_path(struct shading *s, const struct params *p)
{
    const struct dual_fibre f = fibre_of(p);
    const bool asked = p->render.path == 2; // direct, forward, table
    s->refused = NULL;
    if (asked && p->render.scheme == 0)
        s->refused = "render.scheme is paper";
    else if (asked && s->shadowed && p->render.multiple == 1)
        s->refused = "render.multiple is paper";
    else if (asked)
        s->refused = fast_tables_refuse(&f);
    s->tabled = asked && !s->refused;
    s->best = p->render.scheme == 1 && !s->tabled;
}

static void update_fast(struct shading *s, const struct params *p)
{
    const struct dual_fibre f = fibre_of(p);
    if (!s->fast)
        s->fast = fast_tables_create();
    fast_tables_update(s->fast, &f);
    if (s->multiple)
        fast_tables_forward(s->fast, s->dual);
    if (!s->lit)
        s->lit = lit_tables_create();
    const struct lit_fibre lit = {f, s->opaque, s->multiple, p->fibre.d_b};
    lit_tables_fibre(s->lit, &lit);
}

static void choose_light(struct shading *s, const struct params *p,
                         int components)
{
    choose_components(s, components);
    // light that others scattered is known only where what they block is
    s->multiple = s->shadowed && p->render.multiple > 0 &&
                  (s->share[0] > 0 || s->share[1] > 0);
}

// The path stays: parts of a picture go the way of the whole.
void shading_show(struct shading *s, const struct params *p,
                  const struct strands *strands, int components)
{
    choose_light(s, p, components);
    name_base(s, p, strands, components);
}

void shading_update(struct shading *s, const struct params *p,
                    const struct strands *strands, bool shadowed)
{
    s->shadowed = shadowed;
    choose_light(s, p, p->render.components);
    choose_path(s, p);
    name_base(s, p, strands, p->render.components);
    if (s->best)
        update_lobes(s, p);
    if (s->multiple)
        update_dual(s, p);
    if (s->tabled)
        update_fast(s, p);
    if (wants_tables(s, p) &&
        (!s->tables || s->tables->times != p->render.tables)) {
        xu_tables_destroy(s->tables);
        s->tables = xu_tables_create(p->render.tables);
    }
    float values[4 * PARAMS_ROWS_MAX];
    glsl_params_values(p, values);
    gl.NamedBufferSubData(s->params, 0, 16 * params_row_count, values);
}

// The program of these defines: kept, or compiled in the oldest one's place.
static unsigned program_of(struct shading *s, const char *defines,
                           struct error *err)
{
    struct shading_variant *oldest = &s->variant[0];
    for (int i = 0; i < SHADING_VARIANTS; i++) {
        struct shading_variant *v = &s->variant[i];
        if (v->program && strcmp(v->defines, defines) == 0) {
            v->age = ++s->clock;
            return v->program;
        }
        if (v->age < oldest->age)
            oldest = v;
    }
    unsigned program = program_compute(
        strstr(defines, MARK) ? "lit_mark.comp" : "shade_cells.comp", defines,
        err);
    if (!program)
        return 0;
    program_drop(oldest->program);
    snprintf(oldest->defines, sizeof oldest->defines, "%s", defines);
    oldest->program = program;
    oldest->age = ++s->clock;
    return program;
}

void shading_defines(const struct shading *s, const struct nodes_store *nodes,
                     char out[SHADING_DEFINES])
{
    snprintf(out, SHADING_DEFINES, "%s", s->base);
    if (s->shadowed && nodes)
        add(out, "SHADOW_STORED");
}

void shading_bind_inputs(struct shading *s, unsigned program,
                         const struct strands *strands,
                         const struct nodes_store *nodes)
{
    if (s->m)
        gl.ProgramUniform1i(program, XU_M_LOCATION, s->m);
    if (s->shadowed && nodes) {
        gl.ProgramUniform1ui(program, NODES_STRIDE_LOCATION, nodes->stride);
        gl.ProgramUniform1ui(program, NODES_BEGIN_LOCATION, nodes->begin);
        gl.BindTextureUnit(NODES_UNIT, nodes->texture);
    }
    gl.BindBufferBase(GL_UNIFORM_BUFFER, GLSL_PARAMS_BINDING, s->params);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, strands->position);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, strands->strand);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, strands->colour);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, strands->axis);
    if (s->tables)
        xu_tables_bind(s->tables);
    if (s->best)
        best_lobes_bind(s->lobes);
    if (s->multiple)
        dual_tables_bind(s->dual);
}

void shading_forget(struct shading *s)
{
    if (s->lit)
        lit_tables_forget(s->lit);
}

// Does an edit of the fibre shade the same places once more, so that it pays to
// find out what they read?  Not where shadows are looked up as they are shaded:
// that takes longer.
static bool finds_again(const struct shading *s,
                        const struct shading_sample *how)
{
    return how->again && (how->nodes || !s->shadowed);
}

// Marks what cells of lights' tables the places read.
static bool mark_places(struct shading *s, const struct strands *strands,
                        const struct shading_sample *how, const char *defines,
                        struct error *err)
{
    char words[SHADING_DEFINES];
    snprintf(words, sizeof words, "%s", defines);
    const bool anew =
        lit_tables_kept(s->lit) > 0 && !lit_tables_recorded(s->lit, how->made);
    add(words, anew ? MARK " LIT_NEW" : MARK);
    const unsigned program = program_of(s, words, err);
    if (!program)
        return false;
    lit_tables_mark(s->lit, program, how->made);
    program_use(program);
    gl.ProgramUniform1ui(program, PART_LOCATION, (GLuint)how->part);
    shading_bind_inputs(s, program, strands, how->nodes);
    if (how->nodes)
        picture_dispatch_some(how->picture, how->nodes->stride);
    else
        picture_dispatch(how->picture);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return true;
}

// The sizes of the tables of these lights.
static bool plan_lit(struct shading *s, const struct shading_sample *how,
                     struct error *err)
{
    const struct lights *const l = how->lights;
    struct lit_lights of;
    memset(&of, 0, sizeof of);
    of.count = l->used;
    of.bytes = how->lit_bytes;
    of.spread = how->lit_spread;
    for (int j = 0; j < l->used; j++) {
        of.lambda[j] = l->place[j].lambda;
        of.share[j] = l->place[j].share;
    }
    return lit_tables_lights(s->lit, &of, l, err);
}

// Marks and records where it pays to make them, and what to define.
static bool light_places(struct shading *s, const struct strands *strands,
                         const struct shading_sample *how,
                         char defines[SHADING_DEFINES], struct error *err)
{
    if (!plan_lit(s, how, err))
        return false;
    add(defines, lit_tables_plan(s->lit)->rest > 0 ? "LIT LIT_REST" : "LIT");
    if (!finds_again(s, how))
        return true;
    const bool marked = lit_tables_marked(s->lit, how->made);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, strands->position);
    if (how->nodes)
        gl.BindTextureUnit(NODES_UNIT, how->nodes->texture);
    if (!marked && !lit_tables_recorded(s->lit, how->made) &&
        !lit_tables_keep(s->lit, how->nodes ? how->nodes->stride : 0, err))
        return false;
    if (lit_tables_kept(s->lit) > 0)
        add(defines, "LIT_KEPT");
    return marked || mark_places(s, strands, how, defines, err);
}

bool shading_bind(struct shading *s, const struct strands *strands,
                  const struct shading_sample *how, struct error *err)
{
    char defines[SHADING_DEFINES];
    const bool lit = s->tabled && s->whole && how->lights;
    shading_defines(s, how->nodes, defines);
    if (lit && !light_places(s, strands, how, defines, err))
        return false;
    unsigned program = program_of(s, defines, err);
    if (!program || (s->tabled && !fast_tables_bind(s->fast, err)))
        return false;
    if (lit) {
        shading_bind_inputs(s, program, strands, how->nodes);
        if (!lit_tables_make(s->lit, !finds_again(s, how), err))
            return false;
        if (strstr(defines, "LIT_KEPT"))
            lit_tables_read(s->lit, program);
    }
    program_use(program);
    gl.ProgramUniform1ui(program, PART_LOCATION, (GLuint)how->part);
    gl.ProgramUniform1ui(program, FROM_LOCATION, how->from);
    shading_bind_inputs(s, program, strands, how->nodes);
    return true;
}
