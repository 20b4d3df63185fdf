"""How wrong the resting picture is: in stats, in frame headers, and when not.
"""

from glint_wire import Daemon, equal, run, true

OPTIONS = ("--set", "quality.error_places=48", "--set", "shadow.method=crossings",
           "--set", "shadow.rays=0", "--set", "sky.lights=20")
FULL = 128  # paths a place of the last verdict


def told(c):
    """Frames up to the one that has the full verdict."""
    frames = []
    while True:
        head, body = c.frame()
        c.ask("ack id=%d" % head["id"])
        frames.append((head, body))
        if head.get("error", {}).get("paths") == FULL:
            return frames


def start():
    d = Daemon(*OPTIONS)
    c = d.connect()
    c.ask("stream on window=4")
    return d, c


def verdict_follows_final_frame():
    d, c = start()
    frames = told(c)
    head, body = frames[-1]
    final = [f for f in frames if f[0]["final"]][0]
    equal(body, final[1], "the same bytes again")
    equal(head["revision"], final[0]["revision"], "revision")
    true("error" not in final[0], "nothing is known when it becomes final")
    e = head["error"]
    equal(e["reference"], "path", "reference")
    equal(e["metric"], "rel_rmse", "metric")
    equal(e["revision"], head["revision"], "of this revision")
    true(0 < e["value"] < 2, "an error: %s" % e)
    true(0 < e["ci95"] < e["value"] * 2 + 1, "an interval: %s" % e)
    true(0 < e["places"] <= 48, "places: %s" % e)
    equal(c.ask("stats")["error"], e, "stats say the same")
    true(c.silent(1), "no more than that")
    d.stop()


def worse_picture_has_greater_error():
    d, c = start()
    good = told(c)[-1][0]["error"]
    c.ask("set shadow.method=off")
    bad = told(c)[-1][0]["error"]
    true(bad["value"] - bad["ci95"] > good["value"] + good["ci95"],
         "without shadows: %s, with: %s" % (bad, good))
    true(bad["mean_signed"] > good["mean_signed"], "brighter")
    d.stop()


def display_edit_keeps_verdict():
    d, c = start()
    before = told(c)[-1][0]["error"]
    c.ask("set view.exposure=1")
    after = told(c)[-1][0]["error"]
    true(after.pop("revision") > before.pop("revision"), "newer")
    equal(after, before, "the light is the same")
    d.stop()


def display_edit_does_not_end_it():
    d, c = start()
    while True:
        head = c.frame()[0]
        c.ask("ack id=%d" % head["id"])
        if "error" in head:
            break
    true(head["error"]["paths"] < FULL, "a first verdict")
    revision = c.ask("set view.exposure=1")["revision"]
    e = told(c)[-1][0]["error"]
    equal(e["revision"], revision, "the last verdict is of the newest")
    d.stop()


def edit_stops_it_and_is_judged_anew():
    d, c = start()
    told(c)
    for i in range(8):
        c.ask("set fibre.eta=%g" % (1.4 + i * .02))
    frames = told(c)
    equal(frames[-1][0]["error"]["revision"], frames[-1][0]["revision"],
          "the newest")
    d.stop()


def off_means_none():
    d = Daemon(*OPTIONS, "--set", "quality.error_places=0")
    c = d.connect()
    c.ask("stream on window=4")
    while not c.frame()[0]["final"]:
        pass
    true(c.silent(1), "nothing after the final frame")
    equal(c.ask("stats")["error"], None, "not known")
    d.stop()


def ends_while_it_reads_the_strands():
    d, c = start()
    c.ask("set quality.samples=1")
    c.ask("hair name=builtin:animation")
    revision = c.ask("get fibre.eta")["revision"]
    while True:
        head = c.frame()[0]
        c.ask("ack id=%d" % head["id"])
        if head["revision"] >= revision and head["final"]:
            break
    equal(d.stop()[0], 0, "exit status")


def parts_of_the_light_have_no_truth():
    d = Daemon(*OPTIONS, "--set", "render.components=single")
    c = d.connect()
    c.ask("stream on window=4")
    while not c.frame()[0]["final"]:
        pass
    true(c.silent(1), "nothing after the final frame")
    d.stop()


run([verdict_follows_final_frame, worse_picture_has_greater_error,
     display_edit_keeps_verdict, display_edit_does_not_end_it, edit_stops_it_and_is_judged_anew,
     off_means_none, ends_while_it_reads_the_strands,
     parts_of_the_light_have_no_truth])
