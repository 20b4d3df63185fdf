#!/usr/bin/env python3
"""`glintd fit` as a user calls it: text, JSON, pictures, wrong usage."""
import array
import json
import os
import subprocess
import sys
import tempfile
import zlib

GLINTD = os.environ.get("GLINTD", "build/glintd")
failed = False


def glintd(*args, cache):
    env = dict(os.environ, GLINT_CACHE=cache)
    done = subprocess.run([GLINTD, "fit", *args], capture_output=True,
                          text=True, timeout=120, env=env)
    return done.returncode, done.stdout, done.stderr


def read_exr(path):
    """Floats of a ZIP-compressed scan-line file, as {channel: rows}."""
    data = open(path, "rb").read()
    at, head = 8, {}
    while data[at]:
        name, kind, rest = data[at:at + 512].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = int.from_bytes(data[at:at + 4], "little")
        head[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    x0, y0, x1, y1 = array.array("i", head["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names, c = [], head["channels"]
    while c[0]:
        name, c = c.split(b"\0", 1)
        assert int.from_bytes(c[:4], "little") == 2, "float channels"
        names.append(name.decode())
        c = c[16:]
    assert head["compression"] == b"\3"
    planes = {n: [None] * height for n in names}
    blocks = (height + 15) // 16
    at += 1
    for b in range(blocks):
        o = int.from_bytes(data[at + 8 * b:at + 8 * b + 8], "little")
        y, size = array.array("i", data[o:o + 8])
        lines = min(16, height - y)
        want = lines * width * 4 * len(names)
        raw = data[o + 8:o + 8 + size]
        if size < want:
            raw = bytearray(zlib.decompress(raw))
            for i in range(1, want):
                raw[i] = (raw[i - 1] + raw[i] - 128) & 255
            half = (want + 1) // 2
            out = bytearray(want)
            out[0::2], out[1::2] = raw[:half], raw[half:]
            raw = bytes(out)
        values = array.array("f", raw)
        for line in range(lines):
            for i, n in enumerate(names):
                k = (line * len(names) + i) * width
                planes[n][y + line] = values[k:k + width]
    return planes, head


def check(ok, what):
    global failed
    if not ok:
        failed = True
        print("  false: " + what)


def case(name, run, *args):
    global failed
    failed = False
    try:
        run(*args)
    except Exception as e:  # told, and counted
        failed = True
        print("  %s: %s" % (type(e).__name__, e))
    print(("not ok " if failed else "ok ") + name)
    return failed


def usage(cache):
    for args, word in ((["--lights", "0"], "[1, 200]"),
                       (["--lights", "201"], "[1, 200]"),
                       (["--mode", "best"], "hair, plain"),
                       (["--lights", "3", "--target", "0.1"], "exclude"),
                       (["--hair", "builtin:bob"], "hair")):
        status, out, err = glintd(*args, cache=cache)
        check(status == 2 and not out, "status 2 of %s" % args)
        check(word in err and err.count("\n") == 1, "one line: " + err)
    status, out, err = glintd("--env", "/nonexistent.exr", cache=cache)
    check(status == 1 and not out, "status 1")
    check("nonexistent.exr: No such file" in err, err)


def report(cache):
    status, out, err = glintd("--lights", "12", "--json", cache=cache)
    check(status == 0 and not err, err)
    first = json.loads(out)
    check(first["sky"] == "builtin:studio" and first["mode"] == "hair", "keys")
    check(1 <= len(first["lights"]) <= 12, "lights")
    check(abs(first["predicted_error"] - 0.85 * first["residual"]) < 1e-12,
          "foretold error")
    check(not first["from_cache"], "fresh")
    again = json.loads(glintd("--set", "sky.lights=12", "--json",
                              cache=cache)[1])
    check(again["from_cache"], "from the cache")
    check(again["lights"] == first["lights"], "the same lights")
    fresh = json.loads(glintd("--lights=12", "--json", "--no-cache",
                              cache=cache)[1])
    check(not fresh["from_cache"] and fresh["lights"] == first["lights"],
          "the same lights without cache")
    text = glintd("--lights", "12", cache=cache)[1]
    rows = [x for x in text.splitlines() if x.strip().endswith("%")]
    check(len(rows) == len(first["lights"]), "a row per light")
    plain = json.loads(glintd("--lights", "12", "--mode", "plain", "--json",
                              cache=cache)[1])
    check(plain["mode"] == "plain" and plain["lights"] != first["lights"],
          "plain differs")


def target(cache):
    loose = json.loads(glintd("--target", "0.2", "--json", cache=cache)[1])
    tight = json.loads(glintd("--target", "0.03", "--json", cache=cache)[1])
    check(1.3 * loose["residual"] <= 0.2, "0.2 is met")
    check(1.3 * tight["residual"] <= 0.03, "0.03 is met")
    check(len(loose["lights"]) < len(tight["lights"]), "more for less error")


def pictures(cache):
    prefix = os.path.join(cache, "x")
    status, out, err = glintd("--lights", "12", "--out", prefix, cache=cache)
    check(status == 0, err)
    maps = {k: read_exr("%s_%s.exr" % (prefix, k))
            for k in ("map", "lights", "residual")}
    m, l, r = (maps[k][0] for k in ("map", "lights", "residual"))
    check(maps["map"][1]["sky"] == b"builtin:studio", "named in the header")
    check(len(m["R"]) == 256 and len(m["R"][0]) == 512, "size")
    worst = max(abs(m[c][y][x] - l[c][y][x] - r[c][y][x])
                for c in "RGB" for y in range(0, 256, 5)
                for x in range(0, 512, 7))
    check(worst < 1e-5, "map - lights = residual within rounding: %g" % worst)
    check(max(max(row) for row in m["R"]) > 5, "lamps in the map")
    status, out, err = glintd("--lights", "12", "--out",
                              "/nonexistent/x", cache=cache)
    check(status == 1 and "/nonexistent/x_map.exr" in err, err)


def main():
    with tempfile.TemporaryDirectory() as cache:
        bad = [case("fit: wrong usage", usage, cache),
               case("fit: report and cache", report, cache),
               case("fit: lights from a target", target, cache),
               case("fit: pictures", pictures, cache)]
    return any(bad)


if __name__ == "__main__":
    sys.exit(main())
