// spread.glsl - which piece of work a group does.  A driver that runs groups on a
// CPU may hand each of its threads one stretch of them; pictures and tables cost
// more here than there.  So neighbouring groups do pieces that lie apart, and any
// stretch of an eighth of the groups has some of everywhere.
// groups: a multiple of 8 (GL_SPREAD of gl.h).
uint spread_group(uint group, uint groups)
{
    uint far = groups / 8u;
    return group % far * 8u + group / far;
}

// gl_dispatch_spread: the group's piece.
uint spread_piece()
{
    return spread_group(gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x,
                        gl_NumWorkGroups.x * gl_NumWorkGroups.y);
}
