#version 450 core
// Closes a sample's part of the list and sizes the dispatches that work on it.
#include "cells.glsl"
layout(local_size_x = 1) in;
layout(location = 0) uniform uint kept;       // index of this sample's part
layout(location = 1) uniform uint close_part; // 1: the part ends at `listed`

const uint ROW_GROUPS = 32768u; // GL_ROW_GROUPS of gl.h

void main()
{
    if (close_part == 1u)
        list_end[kept] = listed;
    uint begin = kept > 0u ? list_end[kept - 1u] : 0u;
    shaded = list_end[kept] - begin;
    uint groups = (shaded + 63u) / 64u, x = min(groups, ROW_GROUPS);
    uint rows = (groups + ROW_GROUPS - 1u) / ROW_GROUPS;
    dispatch = uvec4(x, max(rows, 1u), 1u, begin);
}
