#!/usr/bin/env python3
"""`glintd render --method`: what it writes, what it tells, what it refuses."""
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GLINTD = os.environ.get("GLINTD", os.path.join(ROOT, "build", "glintd"))
SCENE = ["--hair", "builtin:ponytail", "--env", "builtin:studio", "--size", "24x16"]


def render(out, *more, before=()):
    return subprocess.run([*before, GLINTD, "render", *SCENE, "--out", out, *more],
                          capture_output=True, text=True, timeout=250)


def case(name, ok, shown=""):
    if not ok and shown:
        print("  " + str(shown).replace("\n", "\n  "))
    print("%s %s" % ("ok" if ok else "not ok", name))


with tempfile.TemporaryDirectory() as folder:
    def path(name):
        return os.path.join(folder, name)

    def read(name):
        with open(path(name), "rb") as f:
            return f.read()

    path_args = ["--method", "reference-path", "--spp", "3", "--seed", "5"]
    done = render(path("a.exr"), *path_args, "--progress")
    case("a reference is rendered", done.returncode == 0, done.stderr)
    data = read("a.exr")
    names = [b"variance.%c" % c for c in b"RGBA"] + [b"\0R\0", b"\0A\0"]
    case("its file has the picture and its variance",
         all(n in data[:4096] for n in names) and b"reference-path" in data)
    case("--progress tells samples and seconds",
         "3 of 3 samples, 0 s left" in done.stderr, done.stderr)

    done = render(path("b.exr"), *path_args, before=("taskset", "-c", "0"))
    case("no progress where stderr is no terminal", done.stderr == "", done.stderr)
    case("the same bytes on one core", read("b.exr") == data)
    render(path("c.exr"), *path_args[:-1], "6")
    case("other bytes by another seed", read("c.exr") != data)
    done = render(path("d.exr"), "--method", "reference-single", "--fibre",
                  "marschner", "--spp", "2")
    case("the practical model once scattered",
         done.returncode == 0 and b"marschner" in read("d.exr"), done.stderr)

    refusals = [
        (["--method", "x"], 2, "--method x: is not one of"),
        (["--method", "reference-path", "--fibre", "x"], 2, "--fibre x"),
        (["--method", "reference-path", "--spp", "0"], 2, "[1, 65536]"),
        (["--method", "reference-path", "--size", "3000x2000"], 1, "4194304"),
        (["--method", "reference-path", "--size", "2000x1000", "--spp", "135"],
         1, "at most 134 samples"),
        (["--method", "reference-path", "--layers"], 2, "--layers"),
    ]
    for args, status, text in refusals:
        done = render(path("e.exr"), *args)
        case("refused: " + " ".join(args),
             done.returncode == status and text in done.stderr
             and done.stderr.count("\n") == 1 and not os.path.exists(path("e.exr")),
             "%d %s" % (done.returncode, done.stderr))
    done = render(path("e.png"), "--method", "reference-path")
    case("refused: a reference as PNG", done.returncode == 2, done.stderr)
