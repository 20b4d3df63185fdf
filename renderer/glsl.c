// glsl.c - writes the uniform block of the parameters, text and values.
#include "renderer/glsl.h"

#include <math.h>
#include <string.h>

void glsl_params_text(struct buf *out)
{
    buf_printf(out,
               "layout(std140, binding = %d) uniform Params { vec4 P[%d]; };\n",
               GLSL_PARAMS_BINDING, params_row_count);
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        bool whole = row->type != PARAMS_FLOAT && row->count == 1;
        buf_printf(out, "#define %s_%s %s(P[%d].%s)\n", row->group_name,
                   row->name, whole ? "int" : "", r,
                   row->count == 3 ? "xyz" : "x");
    }
}

void glsl_params_values(const struct params *p, float *out)
{
    struct params resolved = *p;
    params_fibre_resolve(&resolved);
    memset(out, 0, sizeof(float) * 4 * (size_t)params_row_count);
    for (int r = 0; r < params_row_count; r++) {
        const struct params_row *row = &params_rows[r];
        double unit = strcmp(row->unit, "deg") == 0 ? M_PI / 180 : 1;
        for (int i = 0; i < row->count; i++) {
            double v = params_get(&resolved, row, i);
            out[4 * r + i] = isnan(v) ? 0 : (float)(v * unit);
        }
    }
}
