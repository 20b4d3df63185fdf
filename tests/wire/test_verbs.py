#!/usr/bin/env python3
"""Every verb, its reply and its refusals."""
import os
import struct
import subprocess
import time

from glint_wire import (GLINTD, PATIENCE, Daemon, baseline, equal, run, true,
                        written)


def ping(d):
    c = d.connect()
    a, b = c.ask("ping"), c.ask('#x.1:y_-z ping echo="a b\\u00e9"')
    equal(b["tag"], "x.1:y_-z", "tag")
    equal(b["echo"], "a b\u00e9", "echo")
    true("tag" not in a and b["time_us"] >= a["time_us"], "the clock rises")
    c.close()


def hello(d):
    c = d.connect()
    h = c.ask("hello client=test")
    equal(h["protocol"], 1, "protocol")
    equal(h["hair"]["name"], "tuft.hair", "hair")
    equal(h["hair"]["strands"], 300, "strands")
    equal(h["hair"]["points"], 2400, "points")
    equal(h["env"]["name"], "builtin:studio", "env")
    equal(len(h["hair"]["sha256"]), 64, "sha256")
    true(h["device"] and h["program"].startswith("glintd "), "device, program")
    c.close()


def schema_and_get(d):
    c = d.connect()
    rows = c.ask("schema")["params"]
    values = c.ask("get")["values"]
    equal([r["name"] for r in rows], list(values), "same names, same order")
    true(len(rows) > 30, "there are parameters")
    for r in rows:
        true(r["type"] in ("float", "int", "bool", "choice", "rgb", "vec3"),
             r["name"])
        if r["type"] in ("float", "int", "rgb", "vec3"):
            true(r["min"] < r["max"], r["name"])
        if r["type"] == "choice":
            true(r["default"] in r["choices"], r["name"])
        if r["auto"]:
            equal(r["default"], "auto", r["name"])
        for name, *word in r["needs"]:
            need = [x for x in rows if x["name"] == name]
            true(need or name.startswith("--"), r["name"])
            true(not need or word == [] or word[0] in need[0]["choices"],
                 r["name"])
    by_name = {r["name"]: r for r in rows}
    equal(by_name["fibre.eta"]["needs"], [], "eta needs nothing")
    equal(by_name["render.m"]["needs"],
          [["render.scheme", "paper"], ["render.multiple", "paper"]], "any of two")
    equal(by_name["sun1.colour"]["needs"], [["sun1.strength"]], "a number")
    true(by_name["view.colour"]["doc"].endswith(
        "Only with view.background=colour"), "said in words")
    got = c.ask("get fibre.eta camera")["values"]
    equal(set(got), {"fibre.eta", "camera.eye", "camera.target", "camera.up",
                     "camera.fov"}, "a name and a group")
    equal(c.refused("get fibre.eat").name, "fibre.eat", "name")
    equal(c.refused("get fibre.eat").code, "unknown", "code")
    c.close()


def bounds_of_every_parameter(d):
    """At the bounds accepted, beyond them refused, by name, unchanged."""
    c = d.connect()
    before = c.ask("get")["values"]
    for r in c.ask("schema")["params"]:
        name, kind = r["name"], r["type"]
        if kind in ("float", "int", "rgb"):
            for bound, step in ((r["min"], -1), (r["max"], 1)):
                # 8192 x 8192 would be too many pixels in all.
                if not (name.startswith("image.") and step > 0):
                    c.ask("set %s=%r" % (name, bound))
                e = c.refused("set %s=%r" % (name, bound + step))
                equal((e.code, e.name), ("range", name), name)
                true("[" in e.text and "]" in e.text, e.text)
        e = c.refused("set %s=nonsense" % name)
        equal((e.code, e.name), ("type", name), name)
    text = " ".join("%s=%s" % (k, written(v)) for k, v in before.items())
    c.ask("set " + text)
    equal(c.ask("get")["values"], before, "restored")
    c.close()


def range_error_verbatim(d):
    c = d.connect()
    c.send("#8 set fibre.beta_r=200")
    line = c.file.readline()
    equal(line, b'{"ok":false,"tag":"8","error":{"code":"range","name":'
                b'"fibre.beta_r","text":"fibre.beta_r: 200 is not within '
                b'[0.1, 60] deg"}}\n', "the reply, byte for byte")
    c.close()


def set_is_all_or_none(d):
    c = d.connect()
    before = c.ask("get")
    e = c.refused("set fibre.eta=1.7 light.yaw=10 fibre.beta_r=0 view.exposure=1")
    equal(e.name, "fibre.beta_r", "name")
    after = c.ask("get")
    equal(after, before, "values and revision")
    equal(c.refused("set").code, "syntax", "set without a pair")
    equal(c.refused("set seq=1").code, "syntax", "set with seq only")
    equal(c.refused("set fibre.eta=1.6 seq=-1").code, "type", "seq")
    equal(c.refused("set fibre.eta=1.6 echo=" + "x" * 65).code, "limit", "echo")
    equal(c.refused("set image.width=8192 image.height=8192").code, "range",
          "too many pixels")
    equal(c.ask("get"), before, "values and revision")
    r = c.ask("set fibre.eta=1.7 light.yaw=10")["revision"]
    equal(r, before["revision"] + 1, "revision")
    c.close()


def capture_formats(d):
    c = d.connect()
    revision = c.ask("set light.yaw=5")["revision"]
    for options, magic, key in (
            ("format=jpeg", b"\xff\xd8\xff", ("format", "jpeg")),
            ("format=jpeg quality=40 chroma=444", b"\xff\xd8\xff",
             ("quality", 40)),
            ("format=png", b"\x89PNG", ("format", "png")),
            ("format=exr", b"\x76\x2f\x31\x01", ("depth", "half")),
            ("format=exr depth=float", b"\x76\x2f\x31\x01",
             ("depth", "float"))):
        f, body = c.capture(options)
        true(body.startswith(magic), "%s: %r" % (options, body[:8]))
        equal(f[key[0]], key[1], options)
        equal((f["width"], f["height"]), (96, 64), options)
        equal((f["level"], f["final"], f["samples"]), ("final", True, 4),
              options)
        equal(f["revision"], revision, options)
        equal((f["x"], f["y"], f["bytes"]), (0, 0, len(body)), options)
    for bad, code in (("format=gif", "type"), ("quality=0", "range"),
                      ("quality=101", "range"), ("size=0x5", "range"),
                      ("size=8192x8192", "range"), ("size=96", "syntax"),
                      ("revision=x", "type"), ("depth=double", "type"),
                      ("colour=red", "unknown"), ("now", "syntax")):
        e = c.refused("capture " + bad)
        true(e.code == code or (code == "syntax" and e.code == "type"),
             "%s: %s" % (bad, e.reply))
    c.close()


def png_chunks(data):
    at, chunks = 8, []
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        chunks.append((kind, data[at + 8:at + 8 + size]))
        at += 12 + size
    return chunks


def capture_holds_its_state(d):
    """A PNG's text gives the state back: set from it, the bytes are equal."""
    c = d.connect()
    c.ask("set fibre.sigma_a=0.3,0.2,0.1 fibre.alpha_tt=auto light.yaw=33.25 "
          "camera.target=0,0,1")
    _, png = c.capture("format=png")
    text = dict(v.decode("latin-1").split("\0", 1)
                for k, v in png_chunks(png) if k == b"tEXt")
    h = c.ask("hello")
    equal(text["hair"], "tuft.hair", "hair")
    equal(text["hair_sha256"], h["hair"]["sha256"], "hair_sha256")
    equal(text["env_sha256"], h["env"]["sha256"], "env_sha256")
    equal(text["device"], h["device"], "device")
    names = [r["name"] for r in c.ask("schema")["params"]]
    true(set(names) <= set(text), "every parameter is there")
    _, exr = c.capture("format=exr")
    for n in names:
        true(n.encode() + b"\0string\0" in exr, n + " is in the EXR")
    c.ask("set fibre.sigma_a=1 light.yaw=0 camera.target=auto fibre.eta=1.3")
    _, other = c.capture("format=png")
    true(other != png, "another state gives another picture")
    c.ask("set " + " ".join("%s=%s" % (n, text[n]) for n in names))
    _, again = c.capture("format=png")
    equal(again == png, True, "the state in the file makes the file")
    c.close()


def capture_size_is_for_once(d):
    c = d.connect()
    f, one = c.capture("format=png")
    g, _ = c.capture("format=png size=40x30")
    equal((g["width"], g["height"]), (40, 30), "size")
    equal(c.ask("get image.width")["values"]["image.width"], 96, "the state")
    _, two = c.capture("format=png")
    true(one == two, "the same picture after another size")
    c.close()


def capture_is_deterministic(d):
    c = d.connect()
    _, a = c.capture("format=exr depth=float")
    _, b = c.capture("format=exr depth=float")
    true(a == b, "twice the same")
    c.ask("set fibre.sigma_a=2,1,0.5 view.curve=filmic quality.samples=2 "
          "image.width=80")
    _, x = c.capture("format=exr depth=float")
    true(a != x, "an edit shows")
    c.ask("set fibre.sigma_a=0.15,0.25,0.45 view.curve=srgb quality.samples=4 "
          "image.width=96")
    _, b = c.capture("format=exr depth=float")
    true(a == b, "the same after an edit and back")
    c.close()


def a_fresh_start_gives_the_same(d):
    """By edits and capture, or by `glintd render` from nothing: same bytes."""
    c = d.connect()
    state = baseline(d)[4:].split()
    edits = ["fibre.eta=1.7", "light.yaw=20", "fibre.sigma_a=0.3,0.2,0.1"]
    c.ask("set fibre.beta_r=12 view.exposure=3 quality.samples=9")
    c.capture("format=png size=31x17")
    c.ask("set " + " ".join(state + edits).replace(" fibre.eta=1.55", "", 1)
          .replace(" light.yaw=0", "", 1)
          .replace(" fibre.sigma_a=0.15,0.25,0.45", "", 1))
    for end in ("exr", "png", "jpg"):
        out = os.path.join(d.folder.name, "fresh." + end)
        command = [GLINTD, "render", "--hair", d.groom, "--out", out]
        for word in state + edits:
            command += ["--set", word]
        subprocess.run(command, check=True, timeout=PATIENCE,
                       stdout=subprocess.DEVNULL)
        _, body = c.capture("format=" + end.replace("jpg", "jpeg"))
        with open(out, "rb") as f:
            true(f.read() == body, end)
    c.close()


def capture_waits_for_its_revision(d):
    a, b = d.connect(), d.connect()
    now = a.ask("get fibre.eta")["revision"]
    a.send("#w capture format=jpeg revision=%d" % (now + 2))
    a.send("#after ping")
    b.ask("set light.yaw=1")
    true(a.silent(0.3), "not before the revision is made")
    b.ask("set light.yaw=2")
    head, body = a.reply()
    equal((head["tag"], head["ok"]), ("w", True), "the capture")
    true(head["frame"]["revision"] >= now + 2, "its revision")
    equal(len(body), head["frame"]["bytes"], "its bytes")
    equal(a.reply()[0]["tag"], "after", "replies keep their order")
    # Who leaves while waiting leaves nothing behind.
    a.send("capture revision=%d" % (now + 100))
    equal(b.ask("stats")["captures_waiting"], 1, "waiting")
    a.vanish()
    end = time.monotonic() + 5
    while b.ask("stats")["captures_waiting"] and time.monotonic() < end:
        time.sleep(0.05)
    equal(b.ask("stats")["captures_waiting"], 0, "given up")
    b.close()


def hair_and_env(d):
    c = d.connect()
    was = c.ask("hair")
    equal(was["hair"]["name"], "tuft.hair", "in use")
    got = c.ask("#h hair name=builtin:ponytail")
    equal(got["tag"], "h", "tag")
    equal(got["hair"]["strands"], 6000, "strands")
    equal(got["revision"], was["revision"] + 1, "revision")
    for name, code in (("builtin:wig", "unknown"), ("nothing.hair", "file"),
                       ("../root/tuft.hair", "denied"),
                       ("/etc/passwd", "file"), ('""', "range")):
        e = c.refused("hair name=" + name)
        true(e.code == code or name == "/etc/passwd", "%s: %s" % (name, e.reply))
        equal(c.ask("hair")["hair"]["name"], "builtin:ponytail", "it stays")
    with open(d.root + "/bad.hair", "wb") as f:
        f.write(b"HAIR" + bytes(124))
    equal(c.refused("hair name=bad.hair").name, "bad.hair", "a damaged file")
    with open(d.root + "/bad.exr", "wb") as f:
        f.write(b"\x76\x2f\x31\x01" + bytes(60))
    e = c.refused("env name=bad.exr")
    true("bad.exr" in e.text and "/proc" not in e.text, e.text)
    got = c.ask("hair name=tuft.hair")["hair"]
    equal(got, was["hair"], "relative to the root")
    equal(c.ask("hair name=" + d.groom)["hair"], was["hair"], "its full path")
    equal(c.ask("env name=builtin:studio")["env"]["name"], "builtin:studio",
          "env")
    # A radiance file of 4 x 2 grey pixels.
    with open(d.root + "/grey.hdr", "wb") as f:
        f.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" +
                b"\x80\x80\x80\x80" * 8)
    env = c.ask("env name=grey.hdr")["env"]
    equal((env["name"], env["width"], env["height"]), ("grey.hdr", 4, 2), "env")
    f, _ = c.capture("format=jpeg")
    true(f["final"], "a picture under it")
    c.close()


def capture_shows_the_new_hair(d):
    c = d.connect()
    _, a = c.capture("format=png")
    r = c.ask("hair name=builtin:ponytail")["revision"]
    f, b = c.capture("format=png")
    true(f["revision"] >= r and a != b, "the new groom is seen")
    c.ask("hair name=tuft.hair")
    _, again = c.capture("format=png")
    true(a == again, "and the old one again")
    c.close()


def a_capture_names_the_revision_of_its_hair(d):
    """A groom that comes while captures wait: each shows one of the two, under
    the revision that has it."""
    busy, loads, waits = d.connect(), d.connect(), d.connect()
    busy.send("set quality.samples=400")
    busy.reply()
    busy.send("capture format=png")
    loads.send("hair name=builtin:ponytail")
    waits.send("capture format=png size=16x16")
    busy.reply()
    revision = loads.reply()[0]["revision"]
    head, png = waits.reply()
    new = b"builtin:ponytail" in png
    equal(head["frame"]["revision"] >= revision, new,
          "revision %d, new from %d" % (head["frame"]["revision"], revision))
    for c in (busy, loads, waits):
        c.close()


def stats(d):
    c = d.connect()
    c.capture()
    s = c.ask("stats")
    for key in ("stages", "left_out", "memory", "device", "progress", "fit",
                "cleaned", "lights_used", "clients", "frames_sent", "coalesced",
                "errors", "edits", "steps", "hair", "env"):
        true(key in s, key)
    true(s["lights_fitted"] >= 1 and s["lights_used"] >= 1, "lights")
    true(0 <= s["fit"]["residual"] < 1, "residual")
    true(all(0.5 < e < 2 for e in s["fit"]["energy_ratio"]), "energy")
    true(s["memory"]["strands"] > 0, "memory")
    true(all(set(x) == {"what", "why", "bound"} for x in s["left_out"]),
         "left_out")
    true(any(x["what"] == "eccentricity" for x in s["left_out"]),
         "a circular fibre needs no eccentricity")
    c.refused("nonsense")
    equal(c.ask("stats")["errors"], s["errors"] + 1, "errors")
    c.close()


def quit_closes_this_one(d):
    a, b = d.connect(), d.connect()
    equal(a.ask("#q quit")["tag"], "q", "tag")
    true(a.ended(), "closed")
    b.ask("ping")
    b.close()
    a.close()


def unknown_verbs_and_arguments(d):
    c = d.connect()
    for line, code in (("nonsense", "unknown"), ("ping loud=1", "unknown"),
                       ("ping loudly", "syntax"), ("stream", "syntax"),
                       ("stream sideways", "syntax"), ("ack", "syntax"),
                       ("ack id=x", "type"), ("ack id=99999", "range"),
                       ("stream on window=0", "range"),
                       ("stream on window=9", "range"),
                       ("stream on format=bmp", "type"),
                       ("stream on chroma=444", "syntax"),
                       ("hair file=x", "unknown"), ("quit now", "syntax"),
                       ("stats all", "syntax"), ("schema x=1", "unknown"),
                       ("get fibre.eta=1", "unknown")):
        equal(c.refused(line).code, code, line)
    c.ask("ping")
    c.close()


if __name__ == "__main__":
    run([ping, hello, schema_and_get, bounds_of_every_parameter,
         range_error_verbatim, set_is_all_or_none, capture_formats,
         capture_holds_its_state, capture_size_is_for_once,
         capture_is_deterministic, a_fresh_start_gives_the_same,
         capture_waits_for_its_revision,
         hair_and_env, capture_shows_the_new_hair,
         a_capture_names_the_revision_of_its_hair, stats, quit_closes_this_one,
         unknown_verbs_and_arguments], Daemon())
