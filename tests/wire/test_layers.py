#!/usr/bin/env python3
"""An EXR with the picture's layers: their sum is the picture, and nobody else
notices that it was made."""
import os
import subprocess
import tempfile

from exr_layers import read
from glint_wire import GLINTD, PATIENCE, Daemon, equal, run, true

LAYERS = ("single_R", "single_TT", "single_TRT", "global", "local")
# All that the layers are made of, refined by rays.
STATE = ("set shadow.method=crossings shadow.resolution=32 shadow.rays=%d "
         "render.multiple=%s view.head=off fibre.sigma_a=0.1,0.2,0.4 "
         "sun1.strength=2 sun1.azimuth=150 sun1.elevation=20")
EXR = "format=exr depth=float "


def sums(planes):
    """Largest |whole - sum of layers| over the largest value."""
    off = top = 0
    for c in "RGB":
        for i, whole in enumerate(planes[c]):
            off = max(off, abs(whole - sum(planes[n + "." + c][i]
                                           for n in LAYERS)))
            top = max(top, whole)
    true(top > 0.01, "the picture is not black")
    return off / top


def capture(c, options=""):
    c.socket.settimeout(90)  # each part is a program, compiled the first time
    frame, body = c.capture(EXR + options)
    return frame, read(body)[2]


def layers_add_up(d):
    c = d.connect()
    # best and paper, with rays and without, the fibre eccentric
    for rays, multiple, more in ((1, "best", ""), (0, "best", ""),
                                 (0, "paper", " fibre.a=1.2")):
        c.ask(STATE % (rays, multiple) + more)
        frame, planes = capture(c, "layers=on")
        equal(frame.get("layers"), True, "the header says so")
        equal((frame["samples"], frame["final"]), (4, True), "final")
        equal(set(planes), set("RGBA") | {n + "." + x for n in LAYERS
                                          for x in "RGB"}, "channels")
        # Sums of some hundred floats in another order: 1e-6 was measured.
        off = sums(planes)
        print("  rays %d, %s: %.1e of the brightest" % (rays, multiple, off))
        true(off < 1e-5, "the layers' sum is off by %g" % off)
        for n in LAYERS:
            true(max(planes[n + ".G"]) > 1e-3 * max(planes["G"]),
                 n + " is not black")
        plain, whole = capture(c)
        true("layers" not in plain, "no layers unless asked")
        # Without parts tables of each light are read, with all modes added up:
        # up to 4.9e-3 of the brightest was measured to differ.
        near = 0.01 if frame["path"] == "table" else 0
        top = max(planes["R"])
        for x in "RGBA":
            apart = max(abs(a - b) for a, b in zip(whole[x], planes[x]))
            print("  %s apart %.1e" % (x, apart / top))
            true(apart <= near * top, "the whole: " + x)
    c.close()


def layers_are_the_views(d):
    """What render.components shows, bit for bit."""
    c = d.connect()
    c.ask(STATE % (1, "best"))
    planes = capture(c, "layers=on")[1]
    for name, word in zip(LAYERS, ("R", "TT", "TRT", "global", "local")):
        c.ask("set render.components=" + word)
        view = capture(c)[1]
        for x in "RGB":
            true(view[x] == planes[name + "." + x], name)
    c.close()


def what_is_left_out_is_black(d):
    c = d.connect()
    c.ask(STATE % (0, "off"))
    c.ask("set fibre.sigma_a=900")
    planes = capture(c, "layers=on")[1]
    for n in LAYERS[1:]:
        true(not any(planes[n + "." + x][i] for x in "RGB"
                     for i in range(len(planes["R"]))), n + " is black")
    for x in "RGB":
        true(planes[x] == planes["single_R." + x], "R is all there is")
    c.close()


def viewers_do_not_notice(d):
    c, viewer = d.connect(), d.connect()
    revision = c.ask(STATE % (1, "best"))["revision"]
    viewer.ask("stream on format=png window=8")
    while True:
        frame, picture = viewer.frame()
        viewer.ask("ack id=%d" % frame["id"])
        if frame["final"] and frame["revision"] == revision:
            break
    before = c.ask("get")
    frame, _ = c.capture(EXR + "layers=on")
    equal(frame["revision"], revision, "revision")
    equal(c.ask("get"), before, "state and revision")
    true(viewer.silent(0.5), "no frame: nothing changed")
    # What comes next is whole again.
    revision = c.ask("set view.exposure=1")["revision"]
    while frame["revision"] != revision or not frame["final"]:
        frame, _ = viewer.frame()
        viewer.ask("ack id=%d" % frame["id"])
    c.ask("set view.exposure=0")
    true(pixels(c.capture("format=png")[1]) == pixels(picture), "as before")
    viewer.close()
    c.close()


def pixels(png):
    """Its deflated pixels; a captured one has text besides."""
    return png[png.index(b"IDAT"):]


def refusals(d):
    c = d.connect()
    for options, code, word in (
            ("format=png layers=on", "syntax", "png"),
            ("format=exr layers=yes", "type", "yes")):
        e = c.refused("capture " + options)
        equal((e.code, e.name), (code, "layers"), options)
        true(word in e.text, e.text)
    c.ask("set render.components=TT")
    e = c.refused("capture format=exr layers=on")
    equal((e.code, e.name), ("state", "render.components"), "components")
    true("TT" in e.text, e.text)
    c.capture("format=exr layers=off")
    c.capture("format=png layers=off")
    c.close()


def a_client_that_leaves(d):
    """Its layers are dropped; the next capture is whole."""
    c = d.connect()
    c.ask(STATE % (0, "best") + " quality.samples=64")
    e = d.connect()
    e.send("capture format=exr layers=on size=96x64")
    e.vanish()
    first = capture(c, "layers=on size=48x32")[1]
    true(sums(first) < 1e-5, "the sum")
    c.close()


def render_gives_the_same_bytes(d):
    c = d.connect()
    c.ask(STATE % (1, "best"))
    body = c.capture("format=exr layers=on")[1]
    values = c.ask("get")["values"]
    c.close()
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "a.exr")
        command = [GLINTD, "render", "--hair", d.groom, "--layers"]
        for k, v in values.items():
            text = ",".join(map(repr, v)) if isinstance(v, list) else \
                ("on" if v else "off") if isinstance(v, bool) else str(v)
            command += ["--set", k + "=" + text]
        subprocess.run(command + ["--out", out], check=True, timeout=PATIENCE)
        with open(out, "rb") as f:
            true(f.read() == body, "capture and render: the same bytes")
        wrong = subprocess.run(command + ["--out", out + ".png"],
                               stderr=subprocess.PIPE, timeout=PATIENCE)
        equal(wrong.returncode, 2, "a PNG has no layers")
        true(b"--layers" in wrong.stderr, "and it says so")


if __name__ == "__main__":
    run([layers_add_up, layers_are_the_views, what_is_left_out_is_black,
         viewers_do_not_notice, refusals, a_client_that_leaves,
         render_gives_the_same_bytes], Daemon())
