// guard.glsl - where a formula is bent so that it stays finite.  GUARD(id, hit)
// stands next to each such place and is nothing at all but in the probes'
// counting variants (GUARDS), which note for each case which guards it hit:
// what a picture runs is text for text the same without.
//
//   GUARD(id, hit)    notes id where hit (a bool or a vector of them) is true
//   GUARD_LIVE(on)    what follows counts for something: it is false where the
//                     formula itself multiplies the result by zero
// A hit is a bend that matters: where what is bent is next to nothing of the
// whole by the formula itself, the condition says so and no hit is counted.
//   guard_bits        what was noted; a word for each room
// A choice between two formulas is no guard; neither is a limit that the formula
// itself has (smoothstep's ends, light that no fibre gets from behind it).
#ifdef GUARDS
// One line a guard: tests and docs/EXTREMES.md read the names and remarks.
const int GUARD_COS_J = 0;       // cos theta_j, rounded, is not below 0
const int GUARD_COS_D = 1;       // cos theta_d is at least 1e-6
const int GUARD_FALL = 2;        // cos^2 theta_i / cos^2 theta_d is at most 4
const int GUARD_ETA_COLUMN = 3;  // tables of eta' end at 1 and 10
const int GUARD_LAMBDA_WIDE = 4; // tables of lambda' end at 10
const int GUARD_LAMBDA_FINE = 5; // tables of lambda' begin at 1e-3
const int GUARD_TRT_Z = 6;       // h*^2 is at least 1e-6 (eta' just below 2)
const int GUARD_TRT_ANGLE = 7;   // phi* is at least 1e-3 (eta' just below 2)
const int GUARD_TRT_REST = 8;    // b_1 is not below 0 (eq 20)
const int GUARD_R_SUM = 9;       // the alternating sum of eq 13 is not below 0
const int GUARD_ETA_STAR = 10;   // eta* is at least 1.0001 (eq 24)
const int GUARD_WEIGHT = 11;     // a node's weight, rounded, is not below 0
const int GUARD_GAUSS_FLAT = 12; // two circular Gaussians, both constant
const int GUARD_FLAT = 13;       // lambda' is at most 1e6 (best)
const int GUARD_BEST_SINE = 14;  // sine of half a lobe's angle: +-1 (best)
const int GUARD_BEST_SPREAD = 15; // a lobe's spread has a least (best)
const int GUARD_BEST_POWER = 16; // a lobe's power is not below 0 (best)
const int GUARD_DUAL_COS_D = 32;     // cos theta_d is at least 1e-4
const int GUARD_DUAL_R = 33;         // N^G_R: below 0 by over .01 of its mean
const int GUARD_DUAL_TT = 34;        // N^G_TT: the same
const int GUARD_DUAL_TRT = 35;       // N^G_TRT: the same
const int GUARD_DUAL_TILT = 36;      // a channel's shift: at most one width
const int GUARD_DUAL_WIDEN = 37;     // a channel's width: at most twice
const int GUARD_DUAL_FINISH = 38;    // sum over theta_i is not below 0
const int GUARD_DUAL_BACK = 39;      // S_back: below 0 by over .01 of its peak
const int GUARD_DUAL_CENTRE = 40;    // centre of light times S_back: +-pi/2
const int GUARD_DUAL_MORE = 41;      // circular over plain Gaussian: e^60
const int GUARD_DUAL_HALF = 42;      // half a plain Gaussian is not below 0
const int GUARD_DUAL_RANGE = 43;     // mean over theta spans at least .02
const int GUARD_DUAL_SIGMA = 44;     // sigma_b is at least 1e-4
const int GUARD_DUAL_GRAZING = 45;   // cos theta_j is at least 1e-3 (eq 27)
const int GUARD_DUAL_PEAK = 46;      // light times S_back is at most both peaks
const int GUARD_SHADOW_LEAST = 64;    // no G(s) is below 7e-6
const int GUARD_SHADOW_FALL = 65;     // G(s) is not above G(0) (by .001)
const int GUARD_SHADOW_LAW = 66;      // R(s) stays within bounds (.001 of T_f)
const int GUARD_SHADOW_FORWARD = 67;  // T_f is not below T~ (by .001)
const int GUARD_SHADOW_CROSSINGS = 68; // crossings are not below 0 (by .01)
const int GUARD_LIT_EDGE = 80;  // a place lies within its light's table
const int GUARD_LIT_OVER = 81;  // its cell's middle has a theta_j below 90 deg
const int GUARD_LIT_STEEP = 82; // a cell's bend along s: at most 8 values
const int GUARD_LIT_BEND = 83;  // its other second derivatives: at most 2
const int GUARD_LIT_LEAST = 84; // a light's table: below 0 by over .01 of its cell
const int GUARD_LIT_FAR_EDGE = 85;  // a place lies within the far table
const int GUARD_LIT_FAR_OVER = 86;  // its cell's middle: as LIT_OVER
const int GUARD_LIT_FAR_SIGMA = 87; // a channel is at most two cells away
const int GUARD_LIT_FAR_STEEP = 88; // a far cell's bend along s: at most 8
const int GUARD_LIT_FAR_SLOPE = 89; // its gradient: at most 2 values a cell
const int GUARD_LIT_FAR_BEND = 90;  // its other second derivatives: at most 2
const int GUARD_LIT_FAR_LEAST = 91; // the far table: below 0 by over .01 of its cell

const int GUARD_WORDS = 3;
uint guard_bits[GUARD_WORDS] = uint[](0u, 0u, 0u);
bool guard_live = true;

void guard_note(int id, bool hit)
{
    guard_bits[id >> 5] |= hit && guard_live ? 1u << (id & 31) : 0u;
}
void guard_note(int id, bvec2 hit) { guard_note(id, any(hit)); }
void guard_note(int id, bvec3 hit) { guard_note(id, any(hit)); }
void guard_note(int id, bvec4 hit) { guard_note(id, any(hit)); }
#define GUARD(id, hit) guard_note(id, hit)
#define GUARD_LIVE(on) guard_live = (on)
#else
#define GUARD(id, hit)
#define GUARD_LIVE(on)
#endif
