#!/usr/bin/env python3
"""`glintd bench` finishes, its lines and files hold what they promise, and the
headline error grows when the light fit, the visibility or the multiple
scattering gets worse."""
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.dom.minidom

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GLINTD = os.environ.get("GLINTD", os.path.join(ROOT, "build", "glintd"))
KEYS = ("scene method setting median_ms p95_ms rel_rmse rel_mse mean_signed p99 "
        "psnr ssim median_ms_ci95 rel_rmse_ci95 rel_mse_ci95 mean_signed_ci95 "
        "p99_ci95 stages runs").split()
CAUSES = ("light fit", "scattering integral", "visibility", "multiple scattering",
          "all of these", "sampling")
bad = 0


def report(name, good, why=""):
    global bad
    bad += not good
    if not good:
        print("  " + str(why))
    print("%s %s" % ("ok" if good else "not ok", name))
    sys.stdout.flush()


def run(folder, *args):
    env = dict(os.environ, GLINT_CACHE=os.path.join(folder, "cache"))
    done = subprocess.run([GLINTD, "bench", *args], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, timeout=250, env=env,
                          stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def labels(svg):
    """Boxes of the plot's labels, from a monospaced face of size 10."""
    out = []
    for text in xml.dom.minidom.parseString(svg).getElementsByTagName("text"):
        if text.getAttribute("class") == "label":
            x, y = float(text.getAttribute("x")), float(text.getAttribute("y"))
            width = 6.02 * len(text.firstChild.data)
            out.append((x, y - 8, x + width, y + 2))
    return out


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def check_lines(lines):
    settings = {x["setting"]: x for x in lines if x["kind"] == "setting"}
    wanted = {"default", "sky.lights=5", "shadow.method=off", "render.multiple=off"}
    report("the settings that were asked for", set(settings) == wanted, settings.keys())
    missing = [(s, k) for s, x in settings.items() for k in KEYS if k not in x]
    report("every line has every key", not missing, missing)
    finite = all(isinstance(x[k], (int, float)) and x[k] == x[k]
                 for x in settings.values() for k in KEYS[3:11])
    report("times and errors are numbers", finite, settings)
    inside = all(x["rel_rmse_ci95"][0] <= x["rel_rmse"] <= x["rel_rmse_ci95"][1] and
                 x["median_ms"] <= x["p95_ms"] and -1 <= x["ssim"] <= 1 and
                 x["stages"]["shade"] > 0 for x in settings.values())
    report("values lie within their intervals", inside, settings)
    causes = {x["cause"]: x for x in lines if x["kind"] == "cause"}
    report("the error is split into its causes", set(CAUSES) <= set(causes), causes.keys())
    parts = sum(causes[c]["mean_signed"] for c in CAUSES[:4])
    # the four are differences of one chain, place by place: only rounding
    # of single precision (6e-8 of a value a few times the mean) is left
    report("four causes add up to the whole",
           abs(parts - causes["all of these"]["mean_signed"]) < 1e-5, causes)
    return settings


EDIT_KEYS = ("scene edit min_ms median_ms p95_ms edits target_ms error "
             "paper_forward_ms ratio stages work path lights points cpu_ms").split()


def check_edits(folder):
    """--edits: every kind, with its keys, in files that name them."""
    md, svg = os.path.join(folder, "e.md"), os.path.join(folder, "e.svg")
    code, out, err = run(folder, "--edits", "--quick", "--hair", "builtin:ponytail",
                         "--size", "96x64", "--runs", "2", "--places", "20",
                         "--paths", "2", "--set", "sky.lights=4", "--set",
                         "shadow.resolution=32", "--report", md, "--plot", svg)
    report("bench --edits finishes", code == 0, err)
    if code != 0:
        return
    rows = {x["edit"]: x for x in map(json.loads, out.splitlines())}
    missing = [(e, k) for e, x in rows.items() for k in EDIT_KEYS if k not in x]
    report("every edit has every key", len(rows) > 15 and not missing, missing)
    fibre = rows["fibre parameter"]
    report("a fibre edit shades, is compared with paper-forward and judged",
           fibre["stages"]["shade"] > 0 and fibre["ratio"] > 0 and fibre["error"] > 0
           and fibre["path"] == "table" and fibre["work"]["programs"] == 0 and
           abs(fibre["ratio"] * fibre["median_ms"] / fibre["paper_forward_ms"] - 1) < 1e-9,
           fibre)
    report("a display edit shades nothing",
           set(rows["display exposure"]["stages"]) <= {"display", "read"}, rows)
    report("an eccentric fibre is lit directly, and the row says so",
           rows["fibre parameter, a = 0.9"]["path"] == "direct", rows)
    report("a daemon's first frame came", rows["cold start to first frame"]["median_ms"] > 0)
    table_2 = [x for x in rows.values() if "paper_fps" in x]
    report("the paper's scene stands beside its frames per second",
           len(table_2) == 2 and all(x["paper_fps"] == 8.9 for x in table_2), table_2)
    text, plot = open(md).read(), open(svg).read()
    report("page and plot name every edit", all(
        e in text and (e in plot or e.startswith("Table 2")) for e in rows
        if not e.startswith("Table 2")) and "<!-- short -->" in text, text)
    xml.dom.minidom.parseString(plot)


def main():
    with tempfile.TemporaryDirectory() as folder:
        md, svg = os.path.join(folder, "b.md"), os.path.join(folder, "b.svg")
        args = ("--hair", "builtin:ponytail", "--size", "120x80", "--runs", "2",
                "--places", "100", "--exact", "3", "--paths", "32",
                "--picture-paths", "1", "--picture-samples", "1",
                "--set", "sky.lights=16", "--set", "shadow.resolution=64",
                # by rays, so that no cause drowns in the field's coarseness
                "--refined", "--set", "shadow.rays=4",
                "--only", "sky.lights=5,shadow.method=off,render.multiple=off",
                "--quick", "--report", md, "--plot", svg)
        code, out, err = run(folder, *args)
        report("bench finishes", code == 0, err)
        if code != 0:
            return 1
        lines = [json.loads(x) for x in out.splitlines()]
        settings = check_lines(lines)
        error = {s: x["rel_rmse"] for s, x in settings.items()}
        for setting, what in (("sky.lights=5", "the fit"),
                              ("shadow.method=off", "the visibility"),
                              ("render.multiple=off", "the multiple scattering")):
            report("worsening %s raises the headline error" % what,
                   error[setting] > error["default"], error)
        text = open(md).read()
        report("the report names every setting and cause",
               all("| %s" % s in text.replace("**", "") for s in list(settings) +
                   list(CAUSES)), text)
        report("the report shows the plots", "](b.svg)" in text and
               "](b_integral.svg)" in text, text)
        boxes = labels(open(svg).read())
        clash = [(a, b) for i, a in enumerate(boxes) for b in boxes[:i] if overlap(a, b)]
        report("the plot names every setting, apart",
               len(boxes) == len(settings) and not clash, (boxes, clash))
        scene = [x for x in lines if x["kind"] == "scene"][0]
        code, out, err = run(folder, *args, "--runs", "1", "--only", "lights=5")
        again = [json.loads(x) for x in out.splitlines()]
        report("references are found again, with the same errors",
               code == 0 and scene["reference_made"] > 3 and
               again[0]["reference_made"] == 0 and
               [x["rel_rmse"] for x in again if x["kind"] == "setting"] ==
               [error["default"], error["sky.lights=5"]],
               (scene, again[:1], err))
    with tempfile.TemporaryDirectory() as folder:
        check_edits(folder)
    code, out, err = run("/tmp", "--scenes", "nobody")
    report("a scene that is not there is one error",
           code == 1 and len(err.splitlines()) == 1 and "nobody" in err, (code, err))
    code, out, err = run("/tmp", "--runs", "0")
    report("a count out of range is refused", code == 2 and
           re.search(r"--runs: 0 is not within \[1, \d+\]", err), (code, err))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
