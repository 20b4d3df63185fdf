#!/usr/bin/env python3
"""`glintd probe` as a user meets it: values, comments, batches, errors."""
import math
import os
import subprocess

GLINTD = os.environ.get("GLINTD", "build/glintd")
METHOD = ("--scheme", "paper")
CASE = ("1.55 0.0591 -0.0868 0.0434 0.1302 0.1115 0.0557 0.2230 0.2269 1 "
        "0.8261 1.0472 0.4503 -0.6628 1.9860").split()
NAMES = ("eta sigma_a alpha_R alpha_TT alpha_TRT beta_R beta_TT beta_TRT w_c a "
         "lambda_j theta_j phi_j theta_o phi_o").split()
# By brute force, and by the paper's method with m = 4 (independently found).
EXACT = (2.516268e-02, 2.239079e-01, 1.173550e-02)
PAPER = (2.176128e-02, 2.529276e-01, 9.398328e-03)


def probe(text, *options):
    done = subprocess.run([GLINTD, "probe", *options], input=text.encode(),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          timeout=200)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def values(text, *options):
    code, out, err = probe(text, *options)
    assert code == 0 and err == "", (code, err)
    return [[float(x) for x in line.split()] for line in out.splitlines()]


def line(**changes):
    return " ".join(str(changes.get(n, v)) for n, v in zip(NAMES, CASE)) + "\n"


def near(got, want, tolerance):
    assert len(got) == 3, got
    for g, w in zip(got, want):
        assert abs(g - w) <= tolerance * w, (got, want)


def test_values():
    near(values(line(), "--scheme", "exact")[0], EXACT, 1e-6)
    # Bilinear interpolation of the paper's tables; eight times as fine.
    near(values(line(), *METHOD)[0], PAPER, 2e-3)
    near(values(line(), *METHOD, "--tables", "8")[0], PAPER, 5e-5)
    # unless told otherwise, `best`; .011 measured (TRT), .14 by the paper
    near(values(line())[0], EXACT, 0.015)


def test_options():
    four = values(line(), *METHOD, "--tables", "8")[0]
    near(values(line(), *METHOD, "--m", "4", "--nodes", "fine",
                "--tables=8")[0], four, 1e-5)  # both layouts are the same at m = 4
    many = values(line(), *METHOD, "--m", "64", "--tables", "8")[0]
    fine = values(line(), *METHOD, "--m", "64", "--nodes", "fine",
                  "--tables", "8")[0]
    assert abs(many[0] - fine[0]) > 1e-4 * fine[0], (many, fine)
    assert abs(many[0] - four[0]) > 1e-6 * four[0], (many, four)


def test_fast():
    """From tables; where these do not hold, as `best`.  The order of lines and
    their neighbours change nothing."""
    near(values(line(), "--scheme", "fast")[0], EXACT, 0.02)  # 4e-3 measured
    lines = [line(), line(a=1.1), line(theta_o=0.2), line(w_c=0.05), line(eta=1.5),
             line()]
    got = values("".join(lines), "--scheme", "fast")
    best = values("".join(lines), "--scheme", "best")
    assert got[1] == best[1] and got[3] == best[3] and got[0] != best[0]
    assert got[0] == got[5] and got[2] != got[0]
    code, out, err = probe("", "--scheme", "fast", "--what", "half")
    assert code == 2 and out == "" and "single" in err, (code, out, err)


def test_lit():
    """All modes of a light, as the default picture adds them up: near what
    brute force says, with the cells that were read; refused fibres directly."""
    text = line().rstrip("\n") + " 0.9\n"
    (fast,) = values(text, "--what", "lit", "--scheme", "fast")
    (best,) = values(text, "--what", "lit")
    (exact,) = values(text, "--what", "lit", "--scheme", "exact")
    (paper,) = values(text, "--what", "lit", *METHOD)
    assert [len(r) for r in (fast, best, exact, paper)] == [18, 2, 2, 2]
    for k in (0, 1):  # measured: .0063 and .033 (cells), .0036 and .0005, .0026
        assert abs(fast[k] - exact[k]) < .05 * exact[k], (fast, exact)
        assert abs(fast[2 + k] - exact[k]) < .006 * exact[k], (fast, exact)
        assert abs(best[k] - exact[k]) < .005 * exact[k], (best, exact)
        assert fast[k] != fast[2 + k]
    assert fast[4:7] == [8, 9, 3] and fast[7:11] == [0, 7, 4, 3], fast
    for size, want in zip(fast[11:], (math.tau / 16, .1511, math.pi / 8, .5, .4826,
                                      .3365, math.pi / 8)):
        assert abs(size - want) < 1e-3 * want, fast
    # with no glow what is left are the modes
    (bare,) = values(text, "--what", "lit", "--d-b", "0", "--scheme", "exact")
    single = values(line(), "--scheme", "exact")[0]
    assert abs(bare[0] - sum(single)) < 1e-6 * bare[0], (bare, single)
    (cut,) = values(text, "--what", "lit", "--d-b", "0", "--scheme", "fast")
    assert abs(cut[0] - bare[0]) < .05 * bare[0] and cut[0] < fast[0]
    # an eccentric fibre, a caustic too narrow, a light too narrow for a table;
    # neighbours change nothing
    lines = [text] + [line(**c).rstrip("\n") + " 0.9\n" for c in (
        {"a": 1.1}, {"w_c": 0.05}, {"lambda_j": 0.002, "beta_TT": 0.005})] + [text]
    got = values("".join(lines), "--what", "lit", "--scheme", "fast")
    direct = values("".join(lines), "--what", "lit")
    assert got[0] == got[4] == fast
    for k in (1, 2):
        assert got[k][:2] == got[k][2:4] == direct[k], (got[k], direct[k])
        assert got[k][4:11] == [-1] * 7 and got[k][11:] == [0] * 7, got[k]
    assert got[3][4:7] == [-1] * 3 and got[3][0] == got[3][2], got[3]
    assert got[3][7] >= 0, got[3]
    code, out, err = probe(line(), "--what", "lit")
    assert code == 1 and "16 are wanted" in err, err
    for word in ("-0.1", "1.1", "x"):
        code, out, err = probe(text, "--what", "lit", "--d-b", word)
        assert code == 2 and out == "" and "d-b" in err, (code, out, err)


def test_comments():
    text = "# eta ...\n\n" + line() + "   \t\n  # again\n" + line(a=1.1) + "\n"
    got = values(text)
    assert len(got) == 2 and got[0] != got[1], got
    assert got == values(text.replace("\n", "\r\n").replace(" ", "\t"))
    assert got == values(text.rstrip("\n")), "last line without its newline"
    assert values("") == [] and values("# nothing\n") == []


def test_batches():
    """More lines than a batch holds, in order, whatever their neighbours."""
    thetas = [-1.5 + 3 * i / 40000 for i in range(40000)]
    text = "".join(line(theta_o="%.7g" % t, a=1 if i % 3 else 1.1)
                   for i, t in enumerate(thetas))
    got = values(text, *METHOD)
    assert len(got) == len(thetas)
    for i in (0, 1, 3, 16383, 16384, 16385, 32768, 39999):
        alone = values(line(theta_o="%.7g" % thetas[i], a=1 if i % 3 else 1.1),
                       *METHOD)
        assert alone[0] == got[i], (i, alone, got[i])
    assert all(math.isfinite(x) and x >= 0 for row in got for x in row)


def refused(text, *parts, before=0):
    code, out, err = probe(text)
    assert code == 1, (code, out, err)
    assert err.startswith("glintd: ") and err.count("\n") == 1, err
    for part in parts:
        assert part in err, (part, err)
    assert len(out.splitlines()) == before, out


def test_errors():
    refused(line() + "# fine so far\n" + line(eta=3.5), "line 3", "eta", "3.5",
            "[1.05, 3]", before=1)
    limits = {"eta": (1.04, 3.01), "sigma_a": (-0.01, 1001),
              "alpha_R": (-0.53, 0.53), "alpha_TT": (-0.53, 0.53),
              "alpha_TRT": (-0.53, 0.53), "beta_R": (0.0017, 1.06),
              "beta_TT": (0.0017, 1.06), "beta_TRT": (0.0017, 1.06),
              "w_c": (0.008, 1.06), "a": (0.7, 1.42),
              "lambda_j": (0.0009, 2.1), "theta_j": (-1.6, 1.6),
              "phi_j": (-6.4, 6.4), "theta_o": (-1.6, 1.6),
              "phi_o": (-6.4, 6.4)}
    for name in NAMES:
        for value in limits[name]:
            refused(line(**{name: value}), "line 1: %s: %.9g is not within [" %
                    (name, value))
    refused(" ".join(CASE[:14]) + "\n", "line 1", "14", "15")
    refused(" ".join(CASE + ["0"]) + "\n", "line 1", "16", "15")
    for word in ("nan", "inf", "-inf", "1e999", "0x1p0", "1,5", "--1", "eta"):
        refused(line(w_c=word), "line 1: w_c", '"%s"' % word)
    refused("1" * 5000 + "\n", "line 1", "longer")
    refused(line() + "1.55\0 2\n", "line 2", before=1)
    refused("\x1b[31m\n", "line 1: eta")
    code, _, err = probe(line(), "--scheme", "poem")
    assert code == 2 and "paper" in err and "exact" in err, err
    for options in (("--m", "1"), ("--m", "257"), ("--tables", "9"),
                    ("--nodes", "no"), ("--hair", "x"), ("--what",)):
        code, out, err = probe(line(), *options)
        assert code == 2 and out == "" and err.count("\n") == 1, (options, err)


def test_limits_are_legal():
    """Values at the ends of the ranges, rounded as people round them."""
    changes = ({"theta_o": 1.5708}, {"theta_j": -1.5708}, {"beta_R": 1.0472},
               {"w_c": 0.008726}, {"alpha_R": -0.5236}, {"sigma_a": 1000},
               {"lambda_j": 0.001}, {"phi_o": 6.2832}, {"eta": 1.05},
               {"a": 0.71}, {"a": 1.41}, {"eta": "3."}, {"w_c": ".2"})
    for scheme in ("paper", "best", "exact", "fast"):
        got = values("".join(line(**c) for c in changes), "--scheme", scheme)
        assert len(got) == len(changes)
        for row, change in zip(got, changes):
            assert all(math.isfinite(x) and x >= 0 for x in row), (scheme, change)


def main():
    failed = 0
    for name, test in sorted(globals().items()):
        if name.startswith("test_"):
            try:
                test()
                print("ok probe_" + name[5:], flush=True)
            except Exception as fault:  # a crash of the program as well
                failed += 1
                print("  %s: %s" % (type(fault).__name__, fault))
                print("not ok probe_" + name[5:], flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
