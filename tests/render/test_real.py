#!/usr/bin/env python3
"""Every real groom and every real sky renders; odd skies render or are refused
by name; no built-in groom is missing.  Needs the data folder (GLINT_DATA)."""
import os
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GLINTD = os.environ.get("GLINTD", os.path.join(ROOT, "build", "glintd"))
DATA = os.environ.get("GLINT_DATA", os.path.join(ROOT, "..", "shared", "data"))
# A sanitizer looks for bad memory: what parses files meets all of them in the
# unit tests, and every third picture is enough of the rest.
EVERY = 3 if os.environ.get("GLINT_SAN") else 1
SMALL = ["--size", "96x64", "--set", "quality.samples=2", "--set", "sky.lights=10",
         "--set", "shadow.resolution=48", "--set", "shadow.rays=1"]


def report(name, good, why=""):
    if not good:
        print("  " + why)
    print("%s %s" % ("ok" if good else "not ok", name))
    sys.stdout.flush()


def png_pixels(path):
    """RGBA rows of an 8-bit PNG, by the format's own rules."""
    data = open(path, "rb").read()
    at, packed, width, height = 8, b"", 0, 0
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        elif kind == b"IDAT":
            packed += body
        at += size + 12
    raw, row, rows = zlib.decompress(packed), bytearray(4 * width), []
    for y in range(height):
        kind = raw[y * (4 * width + 1)]
        line = bytearray(raw[y * (4 * width + 1) + 1:(y + 1) * (4 * width + 1)])
        for i in range(4 * width):
            a = line[i - 4] if i >= 4 else 0
            b = row[i]
            c = row[i - 4] if i >= 4 else 0
            if kind == 1:
                line[i] = (line[i] + a) & 255
            elif kind == 2:
                line[i] = (line[i] + b) & 255
            elif kind == 3:
                line[i] = (line[i] + (a + b) // 2) & 255
            elif kind == 4:
                p = a + b - c
                best = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))
                line[i] = (line[i] + best[2]) & 255
        row = line
        rows.append(bytes(row))
    return rows


def render(folder, *args):
    out = os.path.join(folder, "x.png")
    if os.path.exists(out):
        os.unlink(out)
    done = subprocess.run([GLINTD, "render", "--out", out, *SMALL, *args],
                          capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return None, done.stderr.strip()
    return png_pixels(out), ""


def lit(rows):
    """Share of pixels that are covered, and of those that are not black."""
    pixels = [r[i:i + 4] for r in rows for i in range(0, len(r), 4)]
    covered = [p for p in pixels if p[3] > 8]
    bright = [p for p in covered if max(p[:3]) > 12]
    return len(covered) / len(pixels), len(bright) / max(1, len(covered))


def renders(folder, name, *args):
    rows, why = render(folder, "--set", "view.background=transparent", "--set",
                       "view.head=off", *args)
    if rows is None:
        report(name, False, why)
        return
    share, bright = lit(rows)
    report(name, share > 0.02 and bright > 0.5,
           "%.3f of the pixels covered, %.3f of those lit" % (share, bright))


def files(kind):
    folder = os.path.join(DATA, kind)
    return [os.path.join(folder, f) for f in sorted(os.listdir(folder))]


# Skies that are no lat-long maps, and what their refusal has to name.
REFUSED = {"deep_LowRes_Balls.exr": "deep", "multipart.0001.exr": "part"}


def main():
    with tempfile.TemporaryDirectory() as folder:
        for groom in "ponytail animation bob dark straight natural".split():
            renders(folder, "builtin:%s renders" % groom, "--hair",
                    "builtin:" + groom, "--set", "tint.exposure=2")
        if not os.path.isdir(DATA):
            print("skip real grooms and skies: no data folder at " + DATA)
            return
        for path in files("hair")[::EVERY]:
            renders(folder, os.path.basename(path) + " renders", "--hair", path,
                    "--set", "tint.exposure=2")
        for path in files("env")[::EVERY]:
            renders(folder, os.path.basename(path) + " lights hair", "--env", path,
                    "--set", "tint.exposure=3")
        for path in files("exr_features"):
            base = os.path.basename(path)
            rows, why = render(folder, "--env", path)
            if base in REFUSED:
                report(base + " is refused by name",
                       rows is None and REFUSED[base] in why and "\n" not in why, why)
            else:
                report(base + " renders, or is refused in one line",
                       rows is not None or (base in why and "\n" not in why), why)


main()
