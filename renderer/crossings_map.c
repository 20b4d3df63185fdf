// crossings_map.c - optical depth maps, the other source of transmittances: one
// a light, along its centre, in layers of summed-area tables, and from them the
// sparse samples that fill the atlas.  Made to be compared with: the field of
// crossings is what pictures use.  How maps are looked up is
// shaders/shadow_map.glsl's business.
#include "renderer/crossings_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/bytes.h"
#include "renderer/gl.h"
#include "renderer/program.h"

enum { LAYERS = 32, LAYERS_MIN = 8 };
enum { SIDE_MIN = 32, GROUP = 64 };
enum { AT_RANGE = 0, AT_SIZE = 0 };
// Bytes of tables that are made before they go into the texture together.
static const uint64_t scratch_most = 32u << 20;
// From where a lookup begins, in cells along the way: nearer, a map holds the
// strand itself.
static const float start_cells = 2.0f;

struct crossings_map_block { // shadow_map.glsl, std140
    float size[4];
    float frame[CROSSINGS_LIGHTS_MAX][4][4];
};

// --- life --------------------------------------------------------------------

void crossings_map_forget(struct crossings *c)
{
    struct crossings_map *m = &c->map;
    const unsigned buffers[] = {m->uniform, m->cells};
    gl.DeleteTextures(1, &m->texture);
    gl.DeleteBuffers(2, buffers);
    m->texture = m->uniform = m->cells = 0;
    m->side = m->slices = 0;
    m->cells_size = 0;
    free(m->block);
    m->block = NULL;
    c->stats.map_bytes = 0;
}

void crossings_map_finish(struct crossings *c)
{
    struct crossings_map *m = &c->map;
    crossings_map_forget(c);
    for (int i = 0; i < 4; i++)
        if (m->program[i])
            program_drop(m->program[i]);
    memset(m, 0, sizeof *m);
}

enum { SPLAT, SPLAT_OPACITY, SUM, SPARSE };

static bool compile(struct crossings_map *m, int which, struct error *err)
{
    static const char *const name[4] = {
        "crossings_map_splat.comp", "crossings_map_splat.comp",
        "crossings_map_sum.comp", "crossings_map_sparse.comp"};
    static const char *const defines[4] = {
        "SHADOW_MAP", "SHADOW_MAP WITH_OPACITY", NULL, "SHADOW_MAP"};
    if (!m->program[which])
        m->program[which] = program_compute(name[which], defines[which], err);
    return m->program[which] != 0;
}

// --- frames ------------------------------------------------------------------

// Half of what a direction sees of the hair's box.
static float half_extent(const struct crossings *c, const float a[3])
{
    float sum = 0;
    for (int k = 0; k < 3; k++)
        sum += 0.5f * fabsf(a[k]) * (c->hair_max[k] - c->hair_min[k]);
    return fmaxf(sum, 1e-3f * c->voxel);
}

// World to cells (0 to `cells`) or layers along an axis.
static float put_row(const struct crossings *c, const float a[3], float cells,
                     float row[4])
{
    const float half = half_extent(c, a) * 1.00001f;
    const float scale = 0.5f * cells / half;
    row[3] = 0.5f * cells;
    for (int k = 0; k < 3; k++) {
        row[k] = scale * a[k];
        row[3] -= row[k] * 0.5f * (c->hair_min[k] + c->hair_max[k]);
    }
    return scale;
}

// The box with the lobe's second moment: exp(-angle^2 / lambda^2) has the
// variance lambda^2 / 2 along each axis across it, a box a third of the square
// of its half width.
static void put_frame(struct crossings *c, int j,
                      const struct crossings_light *l)
{
    float x[3], y[3], (*frame)[4] = c->map.block->frame[j];
    const float cells = (float)(c->map.side - 1);
    crossings_ways_frame(l->direction, x, y);
    const float sx = put_row(c, x, cells, frame[0]);
    const float sy = put_row(c, y, cells, frame[1]);
    const float sz = put_row(c, l->direction, (float)c->map.layers, frame[2]);
    const float lobe = sqrtf(1.5f) * l->lambda / sz; // world, a layer away
    frame[3][0] = lobe * sx;
    frame[3][1] = lobe * sy;
    frame[3][2] = sz / sqrtf(sx * sy); // layers a cell
    frame[3][3] = sx * sy;             // cells a square of the world
}

// --- memory ------------------------------------------------------------------

static uint64_t bytes_of(int side, int slices)
{
    return 4 * (uint64_t)side * (uint64_t)side * (uint64_t)slices;
}

// One and a half times the field's resolution, less where memory ends; layers
// as many as the device has room for.
static bool choose_size(struct crossings *c, int lights, int *side,
                        struct error *err)
{
    GLint slices = 0;
    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &slices);
    const uint64_t most = c->options.budget;
    int layers = LAYERS;
    while (layers > LAYERS_MIN && layers * lights > slices)
        layers /= 2;
    c->map.layers = layers;
    *side = (3 * c->options.resolution / 2 + 3) / 4 * 4;
    while (*side > SIDE_MIN && most > 0 &&
           bytes_of(*side, layers * lights) + c->stats.ways_bytes > most)
        *side -= 4;
    if (lights * layers <= slices &&
        (most == 0 ||
         bytes_of(*side, layers * lights) + c->stats.ways_bytes <= most))
        return true;
    return error_set(err, "limit", "shadow",
                     "shadows: %d lights need maps of at least %llu bytes and "
                     "%d layers; %llu and %d are possible",
                     lights,
                     (unsigned long long)bytes_of(SIDE_MIN, layers * lights),
                     lights * layers, (unsigned long long)most, slices);
}

static bool make_texture(struct crossings *c, int side, int slices,
                         struct error *err)
{
    struct crossings_map *m = &c->map;
    if (!m->block) {
        m->block = bytes_zalloc(1, sizeof *m->block);
        m->uniform = gl_buffer(sizeof *m->block, NULL, "depth maps");
    }
    if (m->texture && m->side == side && m->slices == slices)
        return true;
    gl.DeleteTextures(1, &m->texture);
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &m->texture);
    gl.TextureStorage3D(m->texture, 1, GL_R32F, side, side, slices);
    gl.TextureParameteri(m->texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(m->texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(m->texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(m->texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.ObjectLabel(GL_TEXTURE, m->texture, -1, "depth maps");
    m->side = side;
    m->slices = slices;
    c->stats.map_bytes = bytes_of(side, slices);
    if (gl_check("the shadows' depth maps", err))
        return true;
    crossings_map_forget(c);
    return false;
}

static void grow_cells(struct crossings *c, uint64_t wanted)
{
    struct crossings_map *m = &c->map;
    if (m->cells_size >= wanted)
        return;
    gl.DeleteBuffers(1, &m->cells);
    m->cells = gl_buffer(wanted, NULL, "depth maps' cells");
    m->cells_size = wanted;
    c->stats.scratch_bytes = wanted;
}

// --- making ------------------------------------------------------------------

static void splat(struct crossings *c, int first, int count)
{
    const struct strands *s = c->options.map;
    const GLuint zero = 0,
                 program = c->map.program[s->opacity ? SPLAT_OPACITY : SPLAT];
    const GLuint groups = (s->points + GROUP - 1) / GROUP;
    const GLuint x = groups < GL_ROW_GROUPS ? groups : GL_ROW_GROUPS;
    gl.ClearNamedBufferSubData(
        c->map.cells, GL_R32UI, 0,
        (GLsizeiptr)bytes_of(c->map.side, count * c->map.layers),
        GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s->position);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, s->opacity);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, c->map.cells);
    gl.ProgramUniform2ui(program, AT_RANGE, s->points, (GLuint)first);
    program_use(program);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT |
                     GL_SHADER_STORAGE_BARRIER_BIT);
    gl.DispatchCompute(x, (groups + GL_ROW_GROUPS - 1) / GL_ROW_GROUPS,
                       (GLuint)count);
}

static void sum(struct crossings *c, int first, int count)
{
    const GLuint side = (GLuint)c->map.side,
                 slices = (GLuint)(count * c->map.layers);
    const GLuint program = c->map.program[SUM];
    program_use(program);
    for (GLuint along = 0; along < 2; along++) {
        gl.ProgramUniform3ui(program, AT_SIZE, side, slices, along);
        gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        gl.DispatchCompute((side * slices + GROUP - 1) / GROUP, 1, 1);
    }
    gl.MemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, c->map.cells);
    gl.TextureSubImage3D(c->map.texture, 0, 0, 0, first * c->map.layers,
                         c->map.side, c->map.side, count * c->map.layers,
                         GL_RED, GL_FLOAT, NULL);
    gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

static void sample(struct crossings *c)
{
    const GLuint program = c->map.program[SPARSE];
    const GLuint voxels = (GLuint)crossings_voxels(c);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, c->field);
    program_use(program);
    gl.DispatchCompute((voxels + GROUP - 1) / GROUP, c->block->all[0], 1);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

bool crossings_map_run(struct crossings *c, const struct crossings_light *l,
                       struct error *err)
{
    struct crossings_map *m = &c->map;
    const int lights = c->stats.lights;
    int side = 0;
    if (!compile(m, c->options.map->opacity ? SPLAT_OPACITY : SPLAT, err) ||
        !compile(m, SUM, err) || !compile(m, SPARSE, err) ||
        !choose_size(c, lights, &side, err) ||
        !make_texture(c, side, m->layers * lights, err))
        return false;
    c->stats.resolution = side * 2 / 3;
    m->block->size[0] = (float)(side - 1);
    m->block->size[1] = 1 / (float)side;
    m->block->size[2] = start_cells;
    m->block->size[3] = (float)m->layers;
    for (int j = 0; j < lights; j++)
        put_frame(c, j, &l[j]);
    gl.NamedBufferSubData(m->uniform, 0, sizeof *m->block, m->block);
    const uint64_t each = bytes_of(side, m->layers); // a light's cells
    int most = (int)(scratch_most / each);
    most = most < 1 ? 1 : most > lights ? lights : most;
    grow_cells(c, each * (uint64_t)most);
    crossings_bind(c, NULL);
    for (int first = 0; first < lights; first += most) {
        const int count = lights - first < most ? lights - first : most;
        splat(c, first, count);
        sum(c, first, count);
    }
    sample(c);
    return true;
}

void crossings_map_bind(const struct crossings *c)
{
    gl.BindBufferBase(GL_UNIFORM_BUFFER, CROSSINGS_MAP_BINDING, c->map.uniform);
    gl.BindTextureUnit(CROSSINGS_TEXTURE_UNIT + 1, c->map.texture);
}
