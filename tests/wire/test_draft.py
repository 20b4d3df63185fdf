#!/usr/bin/env python3
"""Drafts: while edits keep coming a coarse picture comes first; at rest the
picture is the one that no draft ever touched."""
import time

from glint_wire import PATIENCE, Daemon, equal, run, true
from test_stream import until_final

# A time that nothing can meet: a draft of whatever edit, whatever the machine.
ALWAYS = "quality.draft_ms=0.01"


def warm(d, c, setting):
    """A first picture, which drafts need to know what the next would take."""
    c.ask("set %s fibre.eta=1.5 camera.fov=30 light.yaw=0" % setting)
    r = c.ask("stream on window=8 format=png")["revision"]
    return until_final(c, r)


def drag(c, edits):
    """The edits with pauses of a moving hand; all frames up to the final."""
    frames = []
    for e in edits:
        r = c.ask("set " + e)["revision"]
        time.sleep(0.03)
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        f, body = c.frame()
        frames.append((f, body))
        c.ask("ack id=%d" % f["id"])
        if f["final"] and f["revision"] == r:
            return frames
    raise AssertionError("no final frame of revision %d" % r)


KINDS = {"fibre": "fibre.eta=%g", "camera": "camera.fov=%g",
         "sky": "light.yaw=%g", "hair": "hair.diameter=%g",
         "lights": "sky.lights=%d"}
FROM = {"fibre": 1.4, "camera": 30, "sky": 10, "hair": 0.1, "lights": 23}
BY = {"fibre": 0.01, "camera": 0.5, "sky": 3, "hair": 0.01, "lights": -1}


def drafts_come_and_the_last_is_final(d):
    """Of every kind of edit; and the final frame is what a capture of that
    state gives in a daemon that made no draft."""
    c = d.connect()
    fresh = Daemon("--set", "shadow.method=crossings",
                   "--set", "shadow.resolution=32")
    other = fresh.connect()
    first = warm(d, c, ALWAYS)
    true(all(f["level"] != "draft" for f in first), "none before a first one")
    other.ask("set fibre.eta=1.5")
    for kind, edit in KINDS.items():
        edits = [edit % (FROM[kind] + BY[kind] * i) for i in range(20)]
        frames = drag(c, edits)
        drafts = [f for f, _ in frames if f["level"] == "draft"]
        true(drafts, "drafts of %s" % kind)
        for f in drafts:
            equal((f["samples"], f["final"]), (0, False), kind)
            true(f["draft"]["divisor"] >= 2 and f["draft"]["stride"] >= 1,
                 f["draft"])
            equal((f["width"], f["height"]), (96, 64), "its size")
            true("shade" in f["stages"], f["stages"])
            if kind == "fibre":
                true("crossings" not in f["stages"], f["stages"])
        if kind != "lights":  # moved or not, by chance of what was shown last
            equal(drafts[-1]["draft"]["coarse_shadows"],
                  kind in ("sky", "hair"), kind)
        equal(any("sky" in f["stages"] for f in drafts), False, "no fit")
        equal("earlier_fit" in drafts[0]["draft"], kind == "lights", kind)
        by_revision = {}
        for f, _ in frames:
            by_revision.setdefault(f["revision"], []).append(f["level"])
        for levels in by_revision.values():
            true("draft" not in levels[1:], "a draft only first: %s" % levels)
        last = frames[-1]
        true("draft" not in last[0], last[0])
        # The files name every parameter, so this one is the same in both.
        other.ask("set %s %s" % (ALWAYS, edits[-1]))
        true(captured(c) == captured(other), "%s: as without drafts" % kind)
        other.ask("set quality.draft_ms=0")
        true(last[1] == plain(other, edits[-1]), "the last frame of " + kind)
    fresh.stop()
    c.close()


def captured(c):
    return c.capture("format=exr depth=float")[1]


def plain(c, edit):
    """The final frame of a state, as streams have it: without its state."""
    r = c.ask("stream on window=8 format=png")["revision"]
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        f, body = c.frame()
        c.ask("ack id=%d" % f["id"])
        if f["final"] and f["revision"] >= r:
            c.ask("stream off")
            return body
    raise AssertionError("no final frame after %s" % edit)


def none_where_none_is_wanted(d):
    c = d.connect()
    warm(d, c, "quality.draft_ms=0")
    before = c.ask("stats")["drafts"]
    for setting in ("quality.draft_ms=0", "quality.draft_ms=1000"):
        c.ask("set " + setting)
        frames = drag(c, ["fibre.eta=%g" % (1.6 + 0.01 * i) for i in range(9)])
        # the full frame of so small a picture is within a second
        equal([f["level"] for f, _ in frames if f["level"] == "draft"], [],
              setting)
    equal(c.ask("stats")["drafts"], before, "drafts made")
    c.close()


def the_display_makes_none(d):
    c = d.connect()
    warm(d, c, ALWAYS)
    before = c.ask("stats")["drafts"]
    frames = drag(c, ["view.exposure=%g" % (0.1 * i) for i in range(1, 9)])
    equal([f["level"] for f, _ in frames if f["level"] == "draft"], [], "view")
    equal(c.ask("stats")["drafts"], before, "drafts made")
    c.ask("set view.exposure=0")
    c.close()


def exr_has_none(d):
    c = d.connect()
    warm(d, c, ALWAYS)
    c.ask("stream on window=8 format=exr")
    before = c.ask("stats")["drafts"]
    drag(c, ["fibre.eta=%g" % (1.5 + 0.01 * i) for i in range(9)])
    equal(c.ask("stats")["drafts"], before, "drafts made")
    c.close()


def captures_see_none(d):
    """A capture in the middle of a drag is final, and of that state."""
    c, editor = d.connect(), d.connect()
    warm(d, c, ALWAYS)
    for i in range(6):
        r = editor.ask("set camera.fov=%g" % (25 + i))["revision"]
        f, body = editor.capture("format=exr depth=float")
        equal((f["level"], f["samples"], f["revision"]), ("final", 4, r), f)
        if i % 2:
            editor.ask("set light.yaw=%d" % (100 + i))
    c.close()
    editor.close()


def a_step_gives_way(d):
    """Edits in the middle of samples that take long; each is shown, and the
    last picture is that of a daemon at rest."""
    options = ("--set", "shadow.method=crossings", "--set", "shadow.rays=16",
               "--set", "sky.lights=12")
    slow = Daemon(*options, size="480x320", samples=64)
    c = slow.connect()
    c.ask("set " + ALWAYS)
    c.ask("stream on window=4 format=png")
    shown = set()
    for i in range(8):
        r = c.ask("set fibre.eta=%g" % (1.4 + 0.01 * i))["revision"]
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            f = c.frame()[0]
            c.ask("ack id=%d" % f["id"])
            shown.add(f["revision"])
            if f["revision"] == r and f["level"] == "full":
                break
        time.sleep(0.1)  # in the refinement now
    true(r in shown, shown)
    stats = c.ask("stats")
    true(stats["cuts"] > 0, "cut: %d of %d" % (stats["cuts"], stats["steps"]))
    c.ask("set quality.samples=1 shadow.rays=1")
    got = c.capture("format=exr depth=float")[1]
    slow.stop()
    fresh = Daemon(*options, size="480x320", samples=1)
    other = fresh.connect()
    other.ask("set fibre.eta=1.47 shadow.rays=1 " + ALWAYS)
    true(got == captured(other), "as if nothing had been cut")
    fresh.stop()


def memory_is_told(d):
    s = d.connect().ask("stats")
    true(s["memory"]["draft"] > 0 and s["drafts"] > 0, s["memory"])
    new = Daemon()
    c = new.connect()
    c.capture("format=png")
    equal(c.ask("stats")["memory"]["draft"], 0, "before a first one")
    new.stop()


if __name__ == "__main__":
    run([drafts_come_and_the_last_is_final, none_where_none_is_wanted,
         the_display_makes_none, exr_has_none, captures_see_none,
         a_step_gives_way, memory_is_told],
        Daemon("--set", "shadow.method=crossings",
               "--set", "shadow.resolution=32"))
