// bench_extremes.c - stiff and extreme cases at length: writes the Markdown
// page that its argument names; fails when a law is broken.  `make extremes`.
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "renderer/egl.h"
#include "tests/check.h"
#include "tests/extremes/frames.h"
#include "tests/extremes/lit_sweep.h"
#include "tests/extremes/multiple.h"
#include "tests/extremes/single.h"
#include "tests/extremes/shadows.h"
#include "tests/extremes/switches_dual.h"

enum {
    SWEEP = 12000, // vectors a region and way: 240,000
    TRUTH = 277,   // through brute force a region, and
    TRUTH_FLAT = 14,
    FIBRES = 53, // times 50 vectors a region and scheme: 53,000
    TRUTH_FIBRES = 4,
    LIT_FIBRES = 53, // times 160 vectors a region: 169,600
    JUMPS = 300,
    JUMPS_DUAL = 60,
    FRAMES = 200,
    FRESH = 5 // every fifth
};

static struct guards_row guards[GUARDS_MAX];
static long hits[SINGLE_WAYS_MAX + MULTIPLE_SCHEMES][VECTORS_REGIONS]
                [GUARDS_MAX];
static long bad;

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void put_quantiles(FILE *out, struct cases_errors *e)
{
    if (e->count == 0)
        fprintf(out, " | -");
    else
        fprintf(out, " | %.1e / %.1e", cases_quantile(e, 0.5),
                cases_quantile(e, 0.99));
}

static void put_head(FILE *out, const char *first, const char *more,
                     int columns)
{
    fprintf(out, "| %s%s |\n|", first, more);
    for (int i = 0; i <= columns; i++)
        fprintf(out, "---|");
    fprintf(out, "\n");
}

static void put_machine(FILE *out)
{
    char line[256], model[200] = "unknown";
    FILE *f = fopen("/proc/cpuinfo", "r");
    while (f && fgets(line, sizeof line, f))
        if (sscanf(line, "model name : %199[^\n]", model) == 1)
            break;
    if (f)
        fclose(f);
    fprintf(out,
            "# Stiff and extreme cases\n\nMade by `make extremes`, which "
            "fails when one of the laws below is broken; a sweep\nof seconds "
            "with the same code is part of `make test`. Machine: %s,\n%ld "
            "processors, no GPU (llvmpipe). Every case is drawn from a fixed "
            "seed.\n\n",
            model, sysconf(_SC_NPROCESSORS_ONLN));
}

static void put_text(FILE *out)
{
    fprintf(
        out,
        "**Laws.** Every value is finite, not negative, and within a bound "
        "that the model\nitself has. For single scattering of a light with "
        "L = 1\n\n"
        "    M_t <= 4 * 1.175 * E_t * l/sqrt(l^2 + w^2) exp(-d^2/(l^2 + "
        "w^2)),\n"
        "    l = pi/2 lambda_j, w = 2 sqrt2 beta_t, d = 2 alpha_t - theta_o - "
        "theta_j:\n\n"
        "cos^2 theta_i/cos^2 theta_d is at most 4; the mode sends at most "
        "E = 1, 1 and 4/27\n(the largest (1-F)^2 F) of what it gets; the "
        "circular Gaussian of a light lies below\nthe plain one pi/2 times as "
        "wide, whose overlap with M_t is the rest; 1.175 is the\nmost by which "
        "the integral of a circular Gaussian exceeds sqrt(pi) lambda, which "
        "is\nwhat scheme `paper` takes for it. For dual scattering "
        "cos theta_i/cos^2 theta_d is at\nmost 1/cos theta_o; attenuations "
        "add up to at most 1. `top` is the largest value in\nparts of its "
        "bound.\n\n"
        "**Errors** are those of the sum of the modes whose cone the light "
        "meets,\n&#124;x - ref&#124;/max(&#124;ref&#124;, 5 %% of its mean "
        "over phi_o); median / p99. `copy`: the\nshader against the same "
        "formulas in double precision (tables 8 x): what single\nprecision "
        "costs. The others are against brute force, so they show the "
        "method.\n\n"
        "**Guards** are the places where a formula is bent to stay finite "
        "(shaders/guard.glsl).\nThe counting variant of the probe notes which "
        "of them a vector hits; a picture's\nprogram has nothing of it.\n\n");
}

// --- single scattering ------------------------------------------------------
static void put_laws(FILE *out)
{
    fprintf(out,
            "## Single scattering: %d vectors a scheme\n\n`glintd probe`'s "
            "shader; one parameter is extreme in each region, the rest "
            "typical.\n`top`, and the share of vectors that hit a guard.\n\n",
            SWEEP * VECTORS_REGIONS);
    fprintf(out, "| region | what");
    for (int w = 0; w < single_way_count; w++)
        fprintf(out, " | %s: top | guarded", single_ways[w].name);
    fprintf(out, " |\n|---|---|");
    for (int w = 0; w < single_way_count; w++)
        fprintf(out, "---|---|");
    fprintf(out, "\n");
    for (enum vectors_region r = 0; r < VECTORS_REGIONS; r++) {
        fprintf(out, "| %s | %s", vectors_regions[r].name,
                vectors_regions[r].what);
        for (int w = 0; w < single_way_count; w++) {
            struct single_law law = single_sweep(&single_ways[w], r, SWEEP);
            bad += law.bad;
            memcpy(hits[w][r], law.hits, sizeof law.hits);
            fprintf(out, " | %.3f | %.2f %%", law.top,
                    100.0 * (double)law.guarded / (double)law.vectors);
        }
        fprintf(out, " |\n");
        fflush(out);
    }
}

static void put_truth(FILE *out)
{
    long vectors = 0;
    char more[400] = " | copy";
    for (int w = 0; w < single_way_count; w++) {
        size_t n = strlen(more);
        snprintf(more + n, sizeof more - n, " | %s | its guarded",
                 single_ways[w].name);
    }
    size_t end = strlen(more);
    snprintf(more + end, sizeof more - end, " | brute force: top");
    fprintf(out, "\n### Against brute force\n\nA scheme breaks where its "
                 "median leaves that of `typical` far behind, or its p99\n"
                 "goes beyond 1: there a lobe's tail lies where the true "
                 "light has ended.\n\n");
    put_head(out, "region", more, 2 + 2 * single_way_count);
    for (enum vectors_region r = 0; r < VECTORS_REGIONS; r++) {
        struct single_truth t;
        single_compare(r, r == VECTORS_FLAT ? TRUTH_FLAT : TRUTH, &t);
        bad += t.bad;
        vectors += t.vectors;
        fprintf(out, "| %s", vectors_regions[r].name);
        put_quantiles(out, &t.copy);
        for (int w = 0; w < single_way_count; w++) {
            put_quantiles(out, &t.way[w]);
            put_quantiles(out, &t.guarded[w]);
        }
        fprintf(out, " | %.3f |\n", t.top);
        fflush(out);
        single_finish(&t);
    }
    fprintf(out,
            "\n%ld vectors. Brute force takes seconds for a flat fibre (its "
            "index depends on the\nlight's azimuth): %d of them in `flat`, "
            "the others are made round.\n",
            vectors, TRUTH_FLAT);
}

// --- dual scattering --------------------------------------------------------
static void put_multiple(FILE *out)
{
    fprintf(out,
            "\n## Dual scattering: %d vectors a scheme through `fibre` and as "
            "many through `multiple`\n\n`a_f + a_b`: the most that one event "
            "sends on. Errors: a_f absolute; M^G (sum) and\nM^L relative, "
            "against brute force (%d fibres of six lights a region).\n\n",
            FIBRES * MULTIPLE_LIGHTS * VECTORS_REGIONS, TRUTH_FIBRES);
    put_head(out, "region",
             " | best: a_f + a_b | top | guarded | paper: a_f + a_b | top | "
             "guarded | best: a_f | M^G | M^L | paper: a_f | M^G | M^L",
             12);
    for (enum vectors_region r = 0; r < VECTORS_REGIONS; r++) {
        struct multiple_truth t;
        fprintf(out, "| %s", vectors_regions[r].name);
        for (int s = 0; s < MULTIPLE_SCHEMES; s++) {
            struct multiple_laws l =
                multiple_sweep((enum dual_scheme)s, r, FIBRES);
            bad += l.fibre.bad + l.multiple.bad;
            memcpy(hits[SINGLE_WAYS_MAX + s][r], l.multiple.hits,
                   sizeof l.multiple.hits);
            fprintf(out, " | %.4f | %.3f | %.2f %%", l.fibre.energy,
                    l.multiple.top,
                    100.0 * (double)l.multiple.guarded /
                        (double)l.multiple.vectors);
        }
        multiple_compare(r, TRUTH_FIBRES, &t);
        for (int s = 0; s < MULTIPLE_SCHEMES; s++) {
            put_quantiles(out, &t.fibre[s]);
            put_quantiles(out, &t.global[s]);
            put_quantiles(out, &t.local[s]);
        }
        multiple_finish(&t);
        fprintf(out, " |\n");
        fflush(out);
    }
}

// --- tables of each light
// -----------------------------------------------------
static void put_lit_row(FILE *out, enum vectors_region r,
                        struct lit_sweep_law *law)
{
    fprintf(out, "| %s | %ld | %.1f %% | %.3f | %.3f | %.2f %%",
            vectors_regions[r].name, law->vectors,
            100.0 * (double)law->narrow / (double)law->vectors, law->top[0],
            law->top[1], 100.0 * (double)law->guarded / (double)law->vectors);
    put_quantiles(out, &law->error);
    fprintf(out, " |\n");
    fflush(out);
}

static void put_lit_guards(FILE *out,
                           const struct lit_sweep_law law[VECTORS_REGIONS])
{
    fprintf(out, "\n| guard | %% of a region's vectors |\n|---|---|\n");
    for (int g = 0; g < GUARDS_MAX; g++) {
        const char *comma = " ";
        if (strncmp(guards[g].name, "LIT_", 4) != 0)
            continue;
        fprintf(out, "| %s: %s |", guards[g].name, guards[g].what);
        for (int r = 0; r < VECTORS_REGIONS; r++)
            if (law[r].hits[g]) {
                fprintf(out, "%s%s %.2f", comma, vectors_regions[r].name,
                        100.0 * (double)law[r].hits[g] /
                            (double)law[r].vectors);
                comma = ", ";
            }
        fprintf(out, "%s |\n", *comma == ' ' ? " none" : "");
    }
}

static void put_lit(FILE *out)
{
    static struct lit_sweep_law law[VECTORS_REGIONS];
    fprintf(
        out,
        "\n## Tables of each light: %d fibres a region\n\nWhat draws the "
        "default picture (docs/METHODS.md, 1.6.1), cells and all: %d "
        "lights a\nfibre, %d vectors; fibres that tables do not hold for "
        "are left out. `no table`: the\nlight is too narrow for one. `top`: "
        "a cell is a parabola of its neighbours, so what it\ngives is "
        "compared with what the light sends at most, wherever it stands. "
        "Guards count\nwhere more than a hundredth of the brightest "
        "arrives; `its guarded`: median and p99 of\nwhat such a vector is "
        "off the tables of modes, of which cells are made, in\nparts of its "
        "value: next to nothing where a narrow lobe's centre has just gone\n"
        "beyond 90 degrees, and cells beside it are bright. Not all can be "
        "none: a cell's slope\nhas a byte, in which 2 values a cell are the "
        "most. Typical vectors: nearly all of\nthem of the far table.\n\n",
        LIT_FIBRES, LIT_SWEEP_LIGHTS, LIT_SWEEP_VECTORS);
    put_head(out, "region",
             " | vectors | no table | directly: top | forward: top | guarded | "
             "its guarded",
             6);
    for (enum vectors_region r = 0; r < VECTORS_REGIONS; r++) {
        law[r] = lit_sweep(r, LIT_FIBRES);
        bad += law[r].bad;
        put_lit_row(out, r, &law[r]);
        cases_finish(&law[r].error);
    }
    put_lit_guards(out, law);
    lit_sweep_close();
}

// --- guards -----------------------------------------------------------------
static void put_hits(FILE *out, int way, int g)
{
    const char *comma = " ";
    fprintf(out, " |");
    for (int r = 0; r < VECTORS_REGIONS; r++)
        if (hits[way][r][g]) {
            fprintf(out, "%s%s %ld", comma, vectors_regions[r].name,
                    hits[way][r][g]);
            comma = ", ";
        }
    if (*comma == ' ')
        fprintf(out, " none");
}

static void put_guards(FILE *out)
{
    long typical = 0;
    fprintf(out,
            "\n## Guards: hits by region\n\nOf %d vectors a region for single "
            "scattering, %d for dual scattering. None may fire in\n`typical`. "
            "A vector that hits one still has the error that the column `its "
            "guarded`\nabove says.\n\n",
            SWEEP, FIBRES * MULTIPLE_LIGHTS);
    fprintf(out, "| guard");
    for (int w = 0; w < single_way_count; w++)
        fprintf(out, " | %s", single_ways[w].name);
    fprintf(out, " | dual, best | dual, paper |\n|---|");
    for (int w = 0; w < single_way_count + MULTIPLE_SCHEMES; w++)
        fprintf(out, "---|");
    fprintf(out, "\n");
    for (int g = 0; g < 64; g++) { // the third word is shadows'
        if (!guards[g].name[0])
            continue;
        fprintf(out, "| %s: %s", guards[g].name, guards[g].what);
        for (int w = 0; w < single_way_count; w++)
            put_hits(out, w, g);
        put_hits(out, SINGLE_WAYS_MAX, g);
        put_hits(out, SINGLE_WAYS_MAX + 1, g);
        fprintf(out, " |\n");
    }
    for (int w = 0; w < SINGLE_WAYS_MAX + MULTIPLE_SCHEMES; w++)
        for (int g = 0; g < GUARDS_MAX; g++)
            typical += hits[w][VECTORS_TYPICAL][g];
    if (typical > 0)
        printf("%ld guards were hit in typical cases\n", typical);
    bad += typical;
}

// --- switches and frames ----------------------------------------------------
static void put_switches(FILE *out)
{
    fprintf(out,
            "\n## Where one formula gives way to another\n\nJump between both "
            "sides, less what the slopes there account for, in parts of the "
            "value\n(or of 1e-3 where it is less); largest of %d cases, three "
            "modes each. At most %.0e.\nWhere the last node leaves, a value "
            "that falls to zero as a square is left.\n\n",
            JUMPS, SWITCHES_LIMIT);
    fprintf(out, "| switch | what changes");
    for (int w = 0; w < single_way_count; w++)
        fprintf(out, " | %s", single_ways[w].name);
    fprintf(out, " |\n|---|---|");
    for (int w = 0; w < single_way_count; w++)
        fprintf(out, "---|");
    fprintf(out, "\n");
    for (int k = 0; k < SWITCHES; k++) {
        fprintf(out, "| %s | %s", switches_rows[k].name,
                switches_rows[k].where);
        for (int w = 0; w < single_way_count; w++) {
            struct cases_errors e = {0};
            switches_measure(k, &single_ways[w], JUMPS, &e);
            double most = cases_quantile(&e, 1);
            fprintf(out, " | %.1e", most);
            bad += !(most <= SWITCHES_LIMIT);
            cases_finish(&e);
        }
        fprintf(out, " |\n");
    }
}

static void put_switches_dual(FILE *out)
{
    fprintf(out,
            "\nThe same for dual scattering (%d cases, five results each):"
            "\n\n| switch | what changes | best | paper |\n"
            "|---|---|---|---|\n",
            JUMPS_DUAL);
    for (int k = 0; k < SWITCHES_DUAL; k++) {
        fprintf(out, "| %s | %s", switches_dual_rows[k].name,
                switches_dual_rows[k].where);
        for (int s = 0; s < MULTIPLE_SCHEMES; s++) {
            struct cases_errors e = {0};
            switches_dual_measure(k, (enum dual_scheme)s, JUMPS_DUAL, &e);
            double most = cases_quantile(&e, 1);
            fprintf(out, " | %.1e", most);
            bad += !(most <= SWITCHES_LIMIT);
            cases_finish(&e);
        }
        fprintf(out, " |\n");
    }
}

static void put_shadows(FILE *out)
{
    struct shadows_row rows[SHADOWS_REGIONS];
    shadows_measure(rows);
    fprintf(out,
            "\n## Shadows: none to hundreds of fibres\n\nT_f from a light's "
            "four packed numbers against exp(-n (1 - a)), a 0 to 1, for a "
            "head\nthat hides nothing, half and nearly all. `bend`: largest "
            "second difference of 4096 steps.\nThe field of voxels itself "
            "ends at 27 fibres.\n\n| fibres crossed | places | broken | "
            "largest error | bend | guards |\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < SHADOWS_REGIONS; i++) {
        const struct shadows_row *r = &rows[i];
        fprintf(out, "| %s | %ld | %ld | %.1e | %.1e |", r->what, r->places,
                r->bad, r->error, r->jump);
        for (int g = 0; g < 32; g++)
            if (r->hits[g])
                fprintf(out, " %s %ld", guards[64 + g].name, r->hits[g]);
        fprintf(out, " |\n");
        bad += r->bad;
    }
}

static void put_row(FILE *out, const struct frames_row *r)
{
    fprintf(out, "| %s | %ld | %ld | %ld | %.1e |\n", r->what, r->frames,
            r->lit, r->bad, r->top);
    bad += r->bad;
}

static void put_frames(FILE *out)
{
    struct frames_all all = frames_run(FRAMES, FRESH);
    fprintf(out,
            "\n## Whole pictures: %ld frames, a sky fit in each\n\n48 x 32 "
            "pixels, two samples, one renderer for all; three tenths of all "
            "parameters of\nfibre, sky, light, suns, shadow and render at a "
            "limit or anywhere in their range.\n`top`: the brightest value in "
            "parts of the sum of all lights' L_j.\n\n",
            all.frames);
    put_head(out, "hair", " | frames | with light | broken | top", 4);
    for (int k = 0; k < FRAMES_HAIRS; k++)
        put_row(out, &all.hair[k]);
    fprintf(out, "\n");
    put_head(out, "sky", " | frames | with light | broken | top", 4);
    for (int k = 0; k < FRAMES_SKIES; k++) {
        put_row(out, &all.sky[k]);
        bad -= all.sky[k].bad; // counted with the hair
    }
    fprintf(out,
            "\n%ld of them were made once more by a fresh renderer; %ld "
            "differed in any bit.\n",
            all.fresh, all.differ);
    bad += all.differ;
}

int main(int argc, char **argv)
{
    struct error err = {0};
    double began = seconds();
    FILE *out = argc == 2 ? fopen(argv[1], "w") : NULL;
    struct egl *gl = egl_create(&err);
    if (!out || !gl || !guards_read(guards)) {
        fprintf(stderr, "usage: bench_extremes PAGE.md; %s\n", err.text);
        return 1;
    }
    check_case("extremes");
    put_machine(out);
    put_text(out);
    put_laws(out);
    put_truth(out);
    put_multiple(out);
    put_lit(out);
    put_guards(out);
    put_switches(out);
    put_switches_dual(out);
    put_shadows(out);
    single_close();
    multiple_close();
    egl_destroy(gl);
    put_frames(out);
    fprintf(out,
            "\nAll of this took %.0f s of a processor, %.0f s by the "
            "clock.\n",
            (double)clock() / CLOCKS_PER_SEC, seconds() - began);
    CHECK(bad == 0 && fclose(out) == 0);
    return check_end();
}
