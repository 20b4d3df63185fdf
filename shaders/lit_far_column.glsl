// lit_far_column.glsl - a column of the far table: its cells over Phi at one
// (ln sigma_f, s, d).  Include after lit.glsl.
struct LitFarColumn {
    bool real; // can be reached, or stands beside one that can
    int rows, s, d, first; // first: its cell with Phi = 0
    float log_sigma;
    vec2 theta; // theta_o, theta_j
};

// n: slices, rows (as many as any slice has), LIT_FAR_D.
LitFarColumn lit_far_column(uint n)
{
    LitFarColumn c;
    const uint D = uint(LIT_FAR_D);
    uint most = uint(lit_far.z), slice = n / (D * most);
    c.s = int(n / D % most);
    c.d = int(n % D);
    c.first = int(n * uint(LIT_FAR_P));
    c.log_sigma = lit_far.x + (float(slice) + 0.5) / LIT_FAR_LOG;
    float per_s = inversesqrt(lit_far.w + exp(2.0 * c.log_sigma)) *
                  (1.0 / LIT_FAR_WIDTHS);
    per_s = min(per_s, lit_far.z * LIT_ROWS);
    c.rows = int(2.0 * LIT_PI * per_s) + 1; // the end's is the last
    float s = (float(c.s) + 0.5) / per_s - LIT_PI;
    float low = lit_theta_o(max(float(c.d) - 1.0, 0.0) / LIT_FAR_D);
    float high = lit_theta_o(min(float(c.d) + 2.0, LIT_FAR_D) / LIT_FAR_D);
    c.real = slice < uint(lit_far.y) && c.s < c.rows &&
             s + 1.51 / per_s > low - 0.5 * LIT_PI &&
             s - 1.51 / per_s < high + 0.5 * LIT_PI;
    c.theta.x = lit_theta_o((float(c.d) + 0.5) / LIT_FAR_D);
    c.theta.y = clamp(s - c.theta.x, -1.5706, 1.5706);
    return c;
}
