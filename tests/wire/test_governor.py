#!/usr/bin/env python3
"""quality.budget_ms and quality.error: what they come to is told, drawn, kept in
the file, and gone when they are off."""
import json
import os
import struct
import subprocess
import tempfile
import time
import zlib

from glint_wire import GLINTD, PATIENCE, Daemon, equal, run, true, \
    write_groom, written


# A front on which choices are known: three numbers of lights, with and without
# rays.  With times of minutes, which no machine needs for 96 x 64 pixels, or of
# microseconds, which none comes near to.
SLOW, QUICK = 1e4, 1e-3
HEAD = ('glint.front 1\nfront device="%s" cores=2 scene="made up" hair="x" '
        'env="y" strands=300\n')
ROW = ("row sky.lights=%d shadow.rays=%d fibre_ms=%g sky_ms=%g camera_ms=%g "
       "rest_ms=%g error=%g\n")


def rows(scale):
    text = ""
    for lights, ms, error in ((40, 100, .5), (20, 50, .6), (10, 25, .7)):
        for rays in (0, 1, 2):
            text += ROW % (lights, rays, ms * scale, 3 * ms * scale,
                           2 * ms * scale, ms * (1 + 4 * rays) * scale,
                           error / (1 + rays))
    return text


def start(front=None, *options):
    d = None
    with tempfile.TemporaryDirectory() as folder:
        args = ["--set", "shadow.method=crossings", "--set", "sky.lights=40"]
        if front is not None:
            path = os.path.join(folder, "front.txt")
            with open(path, "w") as f:
                f.write(front)
            args += ["--front", path]
        d = Daemon(*args, *options, samples=2)
    return d, d.connect()


def chunks(png):
    """Text chunks as a dictionary, and the pixels' bytes."""
    at, texts, pixels = 8, {}, b""
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + size]
        if kind == b"tEXt":
            k, v = body.split(b"\0", 1)
            texts[k.decode()] = v.decode()
        elif kind == b"IDAT":
            pixels += body
        at += 12 + size
    return texts, zlib.decompress(pixels)


def capture(c):
    head, png = c.capture("format=png")
    return (head,) + chunks(png)


def chooses_tells_and_repeats():
    d, c = start(HEAD % "d" + rows(SLOW))
    _, before, plain = capture(c)
    _, _, exact = capture(c)
    equal(exact == plain, True, "a picture is the same twice")
    true("governor" not in before, "nothing is chosen yet")
    equal(c.ask("stats")["governor"], None, "stats before")
    c.ask("set quality.error=0.3")
    told = c.ask("stats")["governor"]
    equal(told["set"], "sky.lights=10 shadow.rays=2", "the quickest, .7 / 3")
    equal(c.ask("get quality.error")["chosen"],
          {"sky.lights": 10, "shadow.rays": 2}, "get")
    equal(c.ask("get sky.lights")["values"]["sky.lights"], 40, "as it was set")
    head, texts, chosen = capture(c)
    true(head["governor"].startswith(
        "quality.error=0.3: sky.lights=10 shadow.rays=2 ("), head)
    equal(texts["governor"], "quality.error=0.3: sky.lights=10 shadow.rays=2",
          "in the file")
    equal((texts["sky.lights"], texts["shadow.rays"], texts["quality.error"]),
          ("10", "2", "0"), "what was drawn is in the file")
    true(chosen != plain, "fewer lights are another picture")
    c.ask("set fibre.eta=1.6 quality.error=0")
    c.ask("set " + " ".join("%s=%s" % (k, v) for k, v in texts.items()
                            if "." in k))
    head, again, fed = capture(c)
    true("governor" not in head and "governor" not in again, "it is off")
    equal(fed == chosen, True, "the file's state makes the file's picture")
    c.ask("set sky.lights=40 shadow.rays=1")
    _, texts, off = capture(c)
    equal(off == plain, True, "off again: the default's picture, bit for bit")
    equal(texts == before, True, "and state")
    d.stop()


def budget_keeps_rays_and_user_values():
    d, c = start(HEAD % "d" + rows(SLOW))
    c.ask("set quality.budget_ms=60000")  # far below every row of this front
    told = c.ask("stats")["governor"]
    equal(told["set"], "sky.lights=10", "the quickest; rays are not touched")
    true("nothing measured is within the budget" in told["why"], told)
    true(told["expects_ms"] > 60000 and told["default_ms"] > 60000, told)
    c.ask("set sky.lights=20")
    equal(c.ask("stats")["governor"]["set"], "", "the user's stays")
    c.ask("set sky.lights=40 shadow.method=off")
    told = c.ask("stats")["governor"]
    equal(told["set"], "", "not what fronts are measured with")
    true("shadow.method" in told["why"], told)
    d.stop()


def wide_budget_is_the_default_or_better():
    d, c = start(HEAD % "d" + rows(QUICK))
    c.ask("set quality.budget_ms=60000")
    told = c.ask("stats")["governor"]
    true(told["expects_error"] <= told["default_error"], told)
    equal(told["set"], "", "here the default is the best")
    equal(told["why"], "the least error within the budget", "why")
    d.stop()


def frames_say_it():
    d, c = start(HEAD % "d" + rows(SLOW))
    c.ask("stream on window=4")
    c.ask("set quality.budget_ms=50 seq=1")
    while True:
        head = c.frame()[0]
        c.ask("ack id=%d" % head["id"])
        if head.get("seq") == 1 and head["final"]:
            break
    true(head["governor"].startswith("quality.budget_ms=50: sky.lights=10 ("),
         head)
    c.ask("set quality.budget_ms=0 seq=2")
    while True:
        head = c.frame()[0]
        c.ask("ack id=%d" % head["id"])
        if head.get("seq") == 2 and head["final"]:
            break
    true("governor" not in head, head)
    d.stop()


def measures_as_it_goes():
    """What frames take is what counts: a front far too slow is
    found out, and with it the default fits."""
    d, c = start(HEAD % "d" + rows(SLOW), "--set", "quality.budget_ms=60000")
    told = c.ask("stats")["governor"]
    equal(told["set"], "sky.lights=10", "at first it goes by the front")
    equal(told["time_ratio"]["seen"], 0, "nothing was measured")
    c.ask("stream on window=4")
    edits, last, drag = 0, time.monotonic(), True
    while told["time_ratio"]["seen"] < 3:  # edits close upon one another
        edits += 1
        c.ask("set fibre.eta=%g" % (1.4 + edits % 50 / 100))
        now = time.monotonic()
        drag, last = drag and now - last < 0.9, now  # else the machine's fault
        while c.frames or not c.silent(0.2):
            c.ask("ack id=%d" % c.frame()[0]["id"])
        told = c.ask("stats")["governor"]
        true(told["set"] == "sky.lights=10" or not drag, "in a drag: %s" % told)
    time.sleep(1.1)
    c.ask("set fibre.eta=1.55")
    told = c.ask("stats")["governor"]
    true(told["time_ratio"]["used"] < 1e-2, told)
    equal(told["set"], "", "all of them fit: the least error")
    d.stop()


def bad_values_and_files():
    d, c = start()
    e = c.refused("set quality.budget_ms=-1")
    equal((e.code, e.name), ("range", "quality.budget_ms"), "below 0")
    equal(c.refused("set quality.error=101").code, "range", "above")
    equal(c.refused("set quality.error=auto").code, "type", "no number")
    c.ask("set quality.budget_ms=40")  # by what ships with the program
    told = c.ask("stats")["governor"]
    true(told["front_shipped"] and told["front"], told)
    d.stop()
    for text in ("", "glint.front 1\nfront\n", HEAD % "d"):
        try:
            start(text)
        except AssertionError as why:
            true("front.txt:" in str(why), str(why))
        else:
            raise AssertionError("a bad --front was taken: %r" % text)


def rendered_as_captured():
    """`glintd render` goes by the same front, and writes the same bytes."""
    front = HEAD % "d" + rows(SLOW)
    d, c = start(front, "--set", "quality.error=0.3")
    _, captured = c.capture("format=png")
    values = c.ask("get")["values"]
    with tempfile.TemporaryDirectory() as folder:
        png = os.path.join(folder, "x.png")
        with open(os.path.join(folder, "front.txt"), "w") as f:
            f.write(front)
        args = [GLINTD, "render", "--hair", d.groom, "--out", png, "--verbose"]
        for name, value in values.items():
            args += ["--set", "%s=%s" % (name, written(value))]
        env = dict(os.environ, GLINT_CACHE=folder)
        done = subprocess.run(args, capture_output=True, env=env,
                              timeout=10 * PATIENCE)
        equal(done.returncode, 0, done.stderr)
        true(b"governor quality.error=0.3: sky.lights=10 shadow.rays=2\n"
             in done.stdout, done.stdout)
        with open(png, "rb") as f:
            equal(f.read() == captured, True, "the same bytes")
        # A cached front that is damaged is logged, and costs nothing else.
        with open(os.path.join(folder, "front.txt"), "w") as f:
            f.write("glint.front 0\n")
        done = subprocess.run(args, capture_output=True, env=env,
                              timeout=10 * PATIENCE)
        equal(done.returncode, 0, done.stderr)
        true(b"front.txt:1: " in done.stderr, done.stderr)
    d.stop()


def measured_front_is_served():
    """What `bench --front` writes is what `serve --front` takes."""
    with tempfile.TemporaryDirectory() as folder:
        hair = os.path.join(folder, "a \\ b.hair")  # a name that wants escapes
        front = os.path.join(folder, "front.txt")
        write_groom(hair)
        done = subprocess.run(
            [GLINTD, "bench", "--front", front, "--only", "shadow.directions",
             "--hair", hair, "--size", "96x64", "--places", "4", "--paths", "2",
             "--picture-paths", "1", "--runs", "1"], capture_output=True,
            env=dict(os.environ, GLINT_CACHE=folder), timeout=10 * PATIENCE)
        equal(done.returncode, 0, done.stderr)
        lines = [json.loads(x) for x in done.stdout.decode().splitlines()]
        got = [x["setting"] for x in lines if x["kind"] == "front"]
        equal(len(got), 4, "settings: %s" % got)
        with open(front) as f:
            text = f.read()
    equal(text.count("\nrow "), 4, text)
    true('shadow.directions=coarse shadow.rays=0 fibre_ms=' in text, text)
    d, c = start(text, "--set", "quality.budget_ms=60000")
    told = c.ask("stats")["governor"]
    equal(told["front"], "a \\ b (file), studio", "the scene that was measured")
    equal(told["why"], "the least error within the budget", "why")
    true(0 < told["expects_error"] <= told["default_error"], told)
    true(told["default_ms"] > 0, told)
    d.stop()


run([chooses_tells_and_repeats, budget_keeps_rays_and_user_values,
     wide_budget_is_the_default_or_better, frames_say_it, measures_as_it_goes,
     bad_values_and_files, rendered_as_captured,
     measured_front_is_served])
