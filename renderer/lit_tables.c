// lit_tables.c - buffers and dispatches of the tables of lights; their shape is
// lit_plan.c's.  What a cell holds is the shaders' affair, which cells are
// read, shading.c's.
#include "renderer/lit_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/lit_source.h"
#include "renderer/program.h"

enum {
    LIGHTS = LIT_PLAN_LIGHTS,
    RECORD_BYTES = 16,
    DIRECT_BYTES = 8,
    ORDER_BYTES = 8,
    // bytes: some drivers end at 128 MiB; what gl_texture_buffer_size adds
    BUFFER_MAX = (128 << 20) - 1024,
    VALUES_BINDING = 12,
    MARKS_BINDING = 13,
    RECORDS_BINDING = 14,
    CELLS_BINDING = 15,
    WANTED_UNIT = 22,
    VALUES_UNIT = 23,
    RECORDS_UNIT = 24,
    ORDER_UNIT = 25,
    DIRECT_UNIT = 26,
    SOURCES_UNIT = 27,
    ORDER_BINS = 4096, // lit_order.comp
    EVERYTHING_LOCATION = 0,
    PLACES_LOCATION = 6, // lit_record.glsl
    GROUP = 64
};
enum wanted { NOTHING, MARKED, ALL };
enum { CELLS, VALUES, WANTED, MARKS, SOURCES, RECORDS, DIRECT, ORDER, BUFFERS };
enum {
    NEAR_VALUES,
    FAR_VALUES = 4,
    NEAR_PACK = 6,
    FAR_PACK,
    CHOOSE,
    COUNT,
    ADD,
    PUT,
    PROGRAMS
};
static const unsigned format[BUFFERS] = {GL_RGBA32UI, GL_RGBA32F,  GL_R32UI,
                                         GL_R32UI,    GL_RGBA32UI, GL_RGBA32UI,
                                         GL_RG32UI,   GL_RG32UI};

struct lit_tables {
    struct lit_fibre fibre;
    bool known; // there is one
    struct lit_plan plan;
    struct lit_lights lights;
    unsigned made;   // the order of records
    uint32_t places; // with records
    struct light_groups groups;
    double spread;    // that they were made with
    bool planned;     // plan is of this fibre and these lights
    unsigned sourced; // the lights that sources and groups are of
    bool near_stale, far_stale, marked, recorded;
    enum wanted wanted; // what `wanted` holds
    unsigned buffer[BUFFERS], texture[BUFFERS], uniform;
    uint64_t bytes[BUFFERS];
    unsigned program[PROGRAMS];
};

struct lit_tables *lit_tables_create(void)
{
    return bytes_zalloc(1, sizeof(struct lit_tables));
}

// All that values read: of the fibre not delta_eta, which is the paper's.
static bool same(const struct lit_fibre *a, const struct lit_fibre *b)
{
    const struct dual_section s = dual_azimuth_section(&a->fibre);
    const struct dual_section t = dual_azimuth_section(&b->fibre);
    const struct dual_fibre *f = &a->fibre, *g = &b->fibre;
    return dual_azimuth_same(&s, &t) && a->opaque == b->opaque &&
           a->multiple == b->multiple && a->d_b == b->d_b &&
           memcmp(f->alpha, g->alpha, sizeof f->alpha) == 0 &&
           memcmp(f->beta, g->beta, sizeof f->beta) == 0;
}

void lit_tables_fibre(struct lit_tables *t, const struct lit_fibre *f)
{
    if (t->known && same(&t->fibre, f))
        return;
    if (f->multiple && !t->fibre.multiple) // records lack what it needs
        lit_tables_forget(t);
    t->fibre = *f;
    t->known = true;
    t->planned = false;
    t->near_stale = t->far_stale = true;
}

void lit_tables_forget(struct lit_tables *t)
{
    t->marked = t->recorded = false;
}

bool lit_tables_marked(const struct lit_tables *t, unsigned made)
{
    return t->marked && t->made == made;
}

bool lit_tables_recorded(const struct lit_tables *t, unsigned made)
{
    return t->recorded && t->made == made;
}

// --- on the device -----------------------------------------------------------

static void drop(struct lit_tables *t, int i)
{
    gl.DeleteTextures(1, &t->texture[i]);
    gl.DeleteBuffers(1, &t->buffer[i]);
    t->texture[i] = t->buffer[i] = 0;
    t->bytes[i] = 0;
    if (i >= RECORDS)
        t->recorded = false;
    if (i == SOURCES)
        t->sourced = 0;
}

static uint64_t most_of(const struct lit_tables *t, int i)
{
    return i >= RECORDS && t->lights.bytes < BUFFER_MAX ? t->lights.bytes
                                                        : BUFFER_MAX;
}

// The next is often larger.
static uint64_t with_slack(uint64_t bytes, uint64_t most)
{
    const uint64_t more = bytes + bytes / 4;
    return more < most ? more : bytes < most ? most : bytes;
}

static bool grow(struct lit_tables *t, int i, uint64_t bytes, struct error *err)
{
    static const char *const name[BUFFERS] = {
        "lit cells",   "lit values",  "lit wanted", "lit marks",
        "lit sources", "lit records", "lit direct", "lit order"};
    const uint32_t zero = 0;
    if (t->bytes[i] >= bytes)
        return true;
    drop(t, i);
    bytes = (with_slack(bytes, most_of(t, i)) + 15) / 16 * 16;
    bytes = gl_texture_buffer_size(bytes);
    gl.CreateBuffers(1, &t->buffer[i]);
    gl.NamedBufferStorage(t->buffer[i], (GLsizeiptr)bytes, NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    gl.ObjectLabel(GL_BUFFER, t->buffer[i], -1, name[i]);
    gl.ClearNamedBufferData(t->buffer[i], GL_R32UI, GL_RED_INTEGER,
                            GL_UNSIGNED_INT, &zero);
    gl.CreateTextures(GL_TEXTURE_BUFFER, 1, &t->texture[i]);
    gl.TextureBuffer(t->texture[i], format[i], t->buffer[i]);
    if (!gl_check("tables of lights", err)) {
        drop(t, i);
        return false;
    }
    t->bytes[i] = bytes;
    if (i >= RECORDS) // these are made with the marks
        return true;
    t->near_stale = t->far_stale = true;
    t->wanted = NOTHING;
    t->marked = false;
    return true;
}

static bool make_room(struct lit_tables *t, const struct lit_plan *p,
                      struct error *err)
{
    const uint64_t far = p->far_cells, near = p->cells;
    const uint64_t values =
        LIT_PLAN_FAR_VALUES * far > near ? LIT_PLAN_FAR_VALUES * far : near;
    return grow(t, CELLS,
                near * LIT_PLAN_NEAR_BYTES + far * LIT_PLAN_FAR_BYTES + 16,
                err) &&
           grow(t, VALUES, values * LIT_PLAN_VALUE_BYTES + 16, err) &&
           grow(t, WANTED, (uint64_t)p->columns * p->tables * 4 + 16, err) &&
           grow(t, MARKS,
                (near > ORDER_BINS ? near : ORDER_BINS) * LIT_PLAN_MARK_BYTES,
                err);
}

// The shapes of all that is made.
static bool plan(struct lit_tables *t, const struct lit_lights *of,
                 struct error *err)
{
    struct lit_plan plan;
    const struct lit_block *const b = &plan.block;
    if (memcmp(&t->lights, of, sizeof *of) != 0)
        t->near_stale = t->far_stale = true;
    for (int i = 0; i < BUFFERS && of->bytes < t->lights.bytes; i++)
        drop(t, i); // they may be larger than is allowed now
    t->lights = *of;
    lit_plan_make(&plan, &t->fibre, of);
    if (!make_room(t, &plan, err))
        return false;
    if (memcmp(b->light, t->plan.block.light, sizeof b->light) != 0) {
        t->marked = false;
        t->wanted = NOTHING;
    }
    if (memcmp(b, &t->plan.block, sizeof *b) != 0)
        gl.NamedBufferSubData(t->uniform, 0, sizeof *b, b);
    t->plan = plan;
    t->planned = true;
    return true;
}

// Which lights are one; records go by that.
static void group(struct lit_tables *t, const struct lights *l, double spread)
{
    const struct light_groups before = t->groups;
    struct light_groups *g = &t->groups;
    bool same;
    lit_source_group(g, l, spread);
    same = before.count == g->count &&
           memcmp(before.member, g->member, sizeof g->member) == 0;
    for (int i = 0; same && i < g->count; i++)
        same = before.group[i].first == g->group[i].first;
    if (!same)
        lit_tables_forget(t);
}

// What the loops read.
static bool put_sources(struct lit_tables *t, const struct lights *l,
                        struct error *err)
{
    struct lit_sources sources;
    struct lit_members members;
    if (!grow(t, SOURCES, sizeof sources, err))
        return false;
    lit_source_put(&sources, l, &t->groups, &t->plan);
    lit_source_members(&members, &t->groups, l);
    gl.NamedBufferSubData(t->buffer[SOURCES], 0, sizeof sources, &sources);
    gl.NamedBufferSubData(t->uniform, sizeof(struct lit_block), sizeof members,
                          &members);
    return true;
}

bool lit_tables_lights(struct lit_tables *t, const struct lit_lights *of,
                       const struct lights *l, struct error *err)
{
    struct lit_lights all = *of;
    const double spread = lit_source_spread(&t->fibre, (double)of->spread);
    const bool same = t->sourced == l->made && t->spread == spread;
    if (t->planned && same && t->lights.bytes == of->bytes)
        return true;
    if (!t->uniform)
        t->uniform =
            gl_buffer(sizeof(struct lit_block) + sizeof(struct lit_members),
                      NULL, "lit block");
    if (!same) // most edits of the fibre leave sources as they are
        group(t, l, spread);
    all.least = 1;
    for (int i = 0; i < t->groups.count; i++)
        all.least = fminf(all.least, (float)t->groups.group[i].lambda);
    const struct lit_plan before = t->plan;
    t->sourced = 0; // until all is done
    if (!plan(t, &all, err))
        return false;
    const bool shaped = memcmp(before.block.light, t->plan.block.light,
                               sizeof before.block.light) != 0;
    if ((!same || shaped || !t->buffer[SOURCES]) && !put_sources(t, l, err))
        return false;
    t->sourced = l->made;
    t->spread = spread;
    return true;
}

const struct light_groups *lit_tables_groups(const struct lit_tables *t)
{
    return &t->groups;
}

const struct lit_plan *lit_tables_plan(const struct lit_tables *t)
{
    return &t->plan;
}

uint32_t lit_tables_kept(const struct lit_tables *t)
{
    return t->places;
}

void lit_tables_read(const struct lit_tables *t, unsigned program)
{
    if (t->places == 0)
        return;
    gl.BindTextureUnit(RECORDS_UNIT, t->texture[RECORDS]);
    gl.BindTextureUnit(DIRECT_UNIT, t->texture[DIRECT]);
    gl.BindTextureUnit(ORDER_UNIT, t->texture[ORDER]);
    gl.ProgramUniform1ui(program, PLACES_LOCATION, t->places);
}

static unsigned program_of(struct lit_tables *t, int i, struct error *err)
{
    static const char *const name[PROGRAMS] = {
        [COUNT] = "lit_order.comp",       [ADD] = "lit_order.comp",
        [PUT] = "lit_order.comp",         [NEAR_PACK] = "lit_pack.comp",
        [FAR_PACK] = "lit_far_pack.comp", [CHOOSE] = "lit_wanted.comp"};
    static const char *const words[4] = {"", "XU_NO_TT_TRT", "WITH_MULTIPLE",
                                         "WITH_MULTIPLE XU_NO_TT_TRT"};
    static const char *const steps[3] = {"STEP=0", "STEP=1", "STEP=2"};
    const char *file = i < FAR_VALUES  ? "lit_values.comp"
                       : i < NEAR_PACK ? "lit_far_values.comp"
                                       : name[i];
    const char *defines = i < FAR_VALUES  ? words[i]
                          : i < NEAR_PACK ? words[i - FAR_VALUES]
                          : i < COUNT     ? ""
                                          : steps[i - COUNT];
    if (!t->program[i])
        t->program[i] = program_compute(file, defines, err);
    if (t->program[i])
        program_use(t->program[i]);
    return t->program[i];
}

static void dispatch_columns(const struct lit_tables *t)
{
    gl.DispatchCompute((t->plan.columns + GROUP - 1) / GROUP, t->plan.tables,
                       1);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT |
                     GL_SHADER_STORAGE_BARRIER_BIT);
}

static void bind_output(const struct lit_tables *t, unsigned binding, int i)
{
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, t->buffer[i]);
}

// Which place comes when.  The buffer of marks serves for the bins, that of
// direct light for which of them a place is in.
static bool sort_places(struct lit_tables *t, uint32_t places,
                        struct error *err)
{
    for (int step = COUNT; step <= PUT; step++) {
        const unsigned p = program_of(t, step, err);
        if (!p)
            return false;
        if (step != ADD)
            gl.ProgramUniform1ui(p, PLACES_LOCATION, places);
        bind_output(t, MARKS_BINDING, MARKS);
        bind_output(t, VALUES_BINDING, ORDER);
        bind_output(t, CELLS_BINDING, DIRECT);
        gl_dispatch(step == ADD ? 1 : places);
        gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT |
                         GL_TEXTURE_FETCH_BARRIER_BIT);
    }
    return true;
}

// What shaders wrote comes before.
static void clear(unsigned buffer)
{
    const uint32_t zero = 0;
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.ClearNamedBufferData(buffer, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT,
                            &zero);
}

bool lit_tables_keep(struct lit_tables *t, uint32_t places, struct error *err)
{
    const uint64_t groups = t->fibre.multiple ? (uint64_t)t->groups.count : 0;
    const uint64_t far = places * groups * RECORD_BYTES;
    const uint64_t near = places * (uint64_t)t->lights.count * DIRECT_BYTES;
    const uint64_t most = most_of(t, RECORDS);
    t->places = far + near <= most ? places : 0;
    t->recorded = false;
    if (t->places == 0)
        return true;
    if (!grow(t, RECORDS, far + 16, err) || !grow(t, DIRECT, near + 16, err) ||
        !grow(t, ORDER, (uint64_t)places * ORDER_BYTES, err))
        return false;
    clear(t->buffer[MARKS]);
    return sort_places(t, places, err);
}

void lit_tables_mark(struct lit_tables *t, unsigned program, unsigned made)
{
    clear(t->buffer[MARKS]);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, LIT_TABLES_BINDING, t->uniform);
    gl.BindTextureUnit(SOURCES_UNIT, t->texture[SOURCES]);
    bind_output(t, MARKS_BINDING, MARKS);
    bind_output(t, RECORDS_BINDING, RECORDS);
    bind_output(t, VALUES_BINDING, DIRECT);
    bind_output(t, CELLS_BINDING, ORDER);
    lit_tables_read(t, program);
    t->marked = true;
    t->recorded = t->places > 0;
    t->made = made;
    t->wanted = NOTHING;
}

static bool choose(struct lit_tables *t, enum wanted wanted, struct error *err)
{
    const unsigned p = program_of(t, CHOOSE, err);
    if (!p)
        return false;
    gl.ProgramUniform1ui(p, EVERYTHING_LOCATION, wanted == ALL);
    gl.BindTextureUnit(VALUES_UNIT, t->texture[MARKS]);
    bind_output(t, VALUES_BINDING, WANTED);
    dispatch_columns(t);
    t->wanted = wanted;
    t->near_stale = true;
    return true;
}

static bool make_near(struct lit_tables *t, struct error *err)
{
    const int variant = (t->fibre.opaque ? 1 : 0) + (t->fibre.multiple ? 2 : 0);
    gl.BindTextureUnit(WANTED_UNIT, t->texture[WANTED]);
    gl.BindTextureUnit(VALUES_UNIT, t->texture[VALUES]);
    bind_output(t, VALUES_BINDING, VALUES);
    bind_output(t, CELLS_BINDING, CELLS);
    if (!program_of(t, NEAR_VALUES + variant, err))
        return false;
    dispatch_columns(t);
    if (!program_of(t, NEAR_PACK, err))
        return false;
    dispatch_columns(t);
    t->near_stale = false;
    return true;
}

static bool make_far(struct lit_tables *t, struct error *err)
{
    const uint64_t columns = t->plan.far_cells / LIT_PLAN_FAR_P;
    gl.BindTextureUnit(VALUES_UNIT, t->texture[VALUES]);
    bind_output(t, VALUES_BINDING, VALUES);
    bind_output(t, CELLS_BINDING, CELLS);
    if (!program_of(t, FAR_VALUES + (t->fibre.opaque ? 1 : 0), err))
        return false;
    gl_dispatch_spread((columns + GROUP - 1) / GROUP);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    if (!program_of(t, FAR_PACK, err))
        return false;
    gl_dispatch_spread((columns + GROUP - 1) / GROUP);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT |
                     GL_SHADER_STORAGE_BARRIER_BIT);
    t->far_stale = false;
    return true;
}

bool lit_tables_make(struct lit_tables *t, bool all, struct error *err)
{
    const enum wanted wanted = all ? ALL : MARKED;
    gl.BindBufferBase(GL_UNIFORM_BUFFER, LIT_TABLES_BINDING, t->uniform);
    // all that there are will do, if they are still of this fibre
    const bool there =
        t->wanted == wanted || (t->wanted == ALL && !t->near_stale);
    if (t->plan.columns > 0 && !there && !choose(t, wanted, err))
        return false;
    if (t->plan.columns > 0 && t->near_stale && !make_near(t, err))
        return false;
    if (t->plan.far_cells > 0 && t->far_stale && !make_far(t, err))
        return false;
    gl.BindTextureUnit(LIT_TABLES_UNIT, t->texture[CELLS]);
    gl.BindTextureUnit(SOURCES_UNIT, t->texture[SOURCES]);
    return true;
}

uint64_t lit_tables_bytes(const struct lit_tables *t)
{
    uint64_t sum = 0;
    for (int i = 0; t && i < BUFFERS; i++)
        sum += t->bytes[i];
    return sum;
}

void lit_tables_destroy(struct lit_tables *t)
{
    if (!t)
        return;
    for (int i = 0; i < BUFFERS && t->uniform; i++)
        drop(t, i);
    if (t->uniform)
        gl.DeleteBuffers(1, &t->uniform);
    for (int i = 0; i < PROGRAMS; i++)
        program_drop(t->program[i]);
    free(t);
}
