#!/usr/bin/env python3
"""Several clients doing anything at once, by a seed; long runs with
GLINT_LONG=1.  What must hold: every reply fits its request, revisions never
fall, the daemon lives, and in the end nothing is left waiting."""
import os
import random
import threading
import time

from glint_wire import PATIENCE, Daemon, Refused, alone, equal, run, true

SECONDS = 60 if os.environ.get("GLINT_LONG") else 3
CLIENTS = 6

LINES = ["ping", "hello", "get", "get fibre", "stats", "schema", "nonsense",
         "set fibre.eta=%(real).3f", "set light.yaw=%(int)d seq=%(int)d",
         "set view.exposure=%(real).2f echo=%(int)d", "set fibre.beta_r=200",
         "set image.width=%(size)d image.height=%(size)d",
         "set quality.samples=%(few)d", "set fibre.sigma_a=%(real).2f",
         "capture format=jpeg", "capture format=png size=%(size)dx%(size)d",
         "capture format=exr", "hair name=tuft.hair", "hair name=none",
         "env name=builtin:studio", "stream on window=%(few)d",
         "stream on format=png", "stream on quality=40", "stream off",
         "ack id=%(newest)d"]


def life(d, seed, failures):
    dice = random.Random(seed)
    try:
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            one_connection(d, dice, end)
    except Exception as why:
        import traceback
        failures.append("seed %d: %s\n%s" % (seed, why,
                                             traceback.format_exc()))


def one_connection(d, dice, end):
    c = d.connect()
    newest, revision = 0, 0
    for i in range(dice.randrange(1, 40)):
        if time.monotonic() > end:
            break
        line = dice.choice(LINES) % {
            "real": dice.uniform(1.1, 2.9), "int": dice.randrange(360),
            "size": dice.randrange(1, 80), "few": dice.randrange(1, 8),
            "newest": newest}
        try:
            got = c.ask("#%d %s" % (i, line))
            equal(got["tag"], str(i), "the tag")
            revision = rising(revision, got.get("revision", revision))
        except Refused as why:
            equal(why.reply["tag"], str(i), "the tag")
            true(any(x in line for x in ("nonsense", "beta_r=200", "none",
                                         "stream on")), "%s: %s" % (line, why))
        for f, _ in c.frames:
            true(f["id"] > newest, "ids rise")
            newest = f["id"]
        c.frames.clear()
    if dice.random() < 0.5:
        c.send("capture format=png")
        c.vanish()
    else:
        c.close()


def rising(before, now):
    true(now >= before, "revision %d after %d" % (now, before))
    return now


def anything_at_once(d):
    failures = []
    lives = [threading.Thread(target=life, args=(d, seed, failures))
             for seed in range(CLIENTS)]
    for x in lives:
        x.start()
    for x in lives:
        x.join(SECONDS + 3 * PATIENCE)
        true(not x.is_alive(), "a client hangs")
    true(not failures, "\n".join(failures))
    c = alone(d)
    f, body = c.capture("format=png")
    equal(f["bytes"], len(body), "and it works")
    c.close()


if __name__ == "__main__":
    run([anything_at_once], Daemon())
