// lit_size.glsl - shape of the tables of lights: renderer/lit_plan.h has it too.
const float LIT_D = 26.0;          // cells over theta_o, finer along the fibre
const float LIT_LEAST = 5e-4;      // T~ below which direct light is left out
const float LIT_FAR_D = 12.0;      // as LIT_D, of the far table
const float LIT_FAR_P = 8.0;       // over |Phi|, 0 to pi
const float LIT_FAR_LOG = 2.0;     // slices a unit of ln sigma
const float LIT_FAR_WIDTHS = .45; // a cell of s, of the narrowest width in it
const float LIT_PI = 3.14159265;
// Of a turn of s, rows a radian: a millionth fewer, so that its end is in the last.
const float LIT_ROWS = 0.159154784;
