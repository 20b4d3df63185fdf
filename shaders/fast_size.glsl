// fast_size.glsl - shape of the tables: renderer/fast_tables.h has it too.
const float FAST_D = 24.0;     // cells over |theta_d|, 0 to pi/2
const float FAST_L = 24.0;     // over ln lambda'
const float FAST_P = 64.0;     // over |Phi|, 0 to pi
const uint FAST_HALF = 24u;    // the slice of the half circle
const uint FAST_CELLS = 38400u; // 25 slices
const float FAST_LEAST = 0.02, FAST_LOG_LEAST = -3.91202301; // lambda' of the end
const float FAST_PER_LOG = 4.0; // cells
const uint FAST_WAYS = 2048u; // entries over theta_j of one crossing
const float FAST_BETA = 1.2; // the largest deviation
const float FAST_BYTE = 1.0 / 63.5; // a second derivative's step
const float FAST_PER_D = FAST_D / 1.57079633; // cells a radian
