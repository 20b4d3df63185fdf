"""No edit waits for a compiler: what is one edit away is compiled ahead."""
import os
import time

from glint_wire import SANITIZED, Daemon, equal, run, true, written

OPTIONS = ("--set", "quality.samples=1", "--set", "shadow.method=crossings",
           "--set", "shadow.rays=1",
           "--set", "shadow.resolution=40", "--set", "sky.lights=6",
           "--set", "image.width=160", "--set", "image.height=120",
           "--set", "quality.error_places=0", "--set", "quality.draft_ms=0")
# Each of them another program, another state of the driver's, or both.
EDITS = (
    ["render.components=" + w for w in
     ("R", "TT", "TRT", "single", "global", "local", "transmittance",
      "crossings", "tangent", "coverage", "strand")] +
    ["render.path=direct", "render.path=forward", "render.scheme=paper",
     "render.multiple=off", "render.multiple=paper", "render.nodes=fine",
     "fibre.a=0.9", "fibre.a=1.2", "fibre.sigma_a=30,40,50",
     "shadow.method=off", "shadow.method=map", "shadow.rays=0",
     "shadow.directions=coarse", "hair.up=x", "sun1.strength=2", "hair.use_colour=true",
     "hair.use_opacity=true", "hair.diameter=1", "view.background=sky",
     "view.background=transparent", "view.curve=filmic", "view.head=false",
     "camera.fov=3", "tint.exposure=1", "light.yaw=40"])


def final(c):
    """The frame that ends the picture of the newest edit."""
    while True:
        head, _ = c.frame()
        c.ask("ack id=%d" % head["id"])
        if head["final"]:
            return head


def busy(d):
    """CPU seconds of the render thread: what it waits for is not its own."""
    tasks = "/proc/%d/task" % d.process.pid
    for task in os.listdir(tasks):
        with open("%s/%s/comm" % (tasks, task)) as f:
            if f.read().strip() != "glint-render":
                continue
        with open("%s/%s/schedstat" % (tasks, task)) as f:
            return 1e-9 * int(f.read().split()[0])
    raise AssertionError("no render thread")


def seconds(d, c, edit):
    began = busy(d)
    revision = c.ask("set " + edit)["revision"]
    while final(c)["revision"] < revision:
        pass
    return busy(d) - began


def warm_daemon():
    """It, a viewer, and what stats say once all is ready."""
    os.environ["GLINT_WARM"] = "1"
    d = Daemon(*OPTIONS)
    c = d.connect()
    c.ask("stream on window=4")
    final(c)
    until = time.monotonic() + 600  # a driver without a cache, a busy machine
    while True:
        told = c.ask("stats")["programs"]
        if told["warm"]:
            return d, c, told
        true(time.monotonic() < until, "warm: %s" % told)
        time.sleep(0.2)


def nothing_is_compiled_for_an_edit():
    d, c, told = warm_daemon()
    equal(told["states_left"], 0, "states left")
    equal(told["left"], 0, "programs left")
    true(told["states"] >= 30, "states: %s" % told)
    base = c.ask("get")["values"]
    for edit in EDITS:
        name = edit.split("=")[0]
        back = "%s=%s" % (name, written(base[name]))
        first = seconds(d, c, edit)
        now = c.ask("stats")["programs"]
        equal(now["compiled"], told["compiled"], "compiled for " + edit)
        seconds(d, c, back)
        second = seconds(d, c, edit)
        seconds(d, c, back)
        # Machine code of one shading program costs .3 to 2.2 s of this thread
        # when it is made; found in the driver's cache, up to .02 s were
        # measured for all that an edit needs.
        true(first < 4 * second + 0.08,
             "%s: %.3f s at first, %.3f s then" % (edit, first, second))
    d.stop()


def ends_while_it_compiles():
    os.environ["GLINT_WARM"] = "1"
    d = Daemon(*OPTIONS)
    c = d.connect()
    c.ask("stream on window=4")
    final(c)
    time.sleep(1)  # it begins .3 s after the last edit
    c.ask("set fibre.beta_r=9")
    final(c)
    told = c.ask("stats")["programs"]
    true(not told["warm"], "not everything is ready at once: %s" % told)
    code, err = d.stop()
    equal((code, err), (0, ""), "the end")


def without_it_edits_compile():
    os.environ["GLINT_WARM"] = "0"
    d = Daemon(*OPTIONS)
    c = d.connect()
    c.ask("stream on window=4")
    final(c)
    told = c.ask("stats")["programs"]
    true(not told["warm"] and told["states"] == 0, "nothing ahead: %s" % told)
    seconds(d, c, "render.path=direct")
    true(c.ask("stats")["programs"]["compiled"] > told["compiled"],
         "the count counts")
    d.stop()


CASES = [ends_while_it_compiles, without_it_edits_compile]
if SANITIZED:  # the compiler under a sanitizer takes longer than a test may
    print("skip nothing_is_compiled_for_an_edit: a sanitized build")
else:
    CASES.append(nothing_is_compiled_for_an_edit)
run(CASES)
