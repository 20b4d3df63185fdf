#!/usr/bin/env python3
"""glint and glintd together: set, get, capture, watch, send, over TCP and over
a Unix socket, on a small picture."""
import os
import subprocess
import sys
import tempfile
import time

GLINT = os.environ.get("GLINT", "build/glint")
GLINTD = os.environ.get("GLINTD", "build/glintd")
LIMIT = 100  # seconds for anything; shaders are compiled on the first frame
MAGIC = {"jpg": b"\xff\xd8\xff", "png": b"\x89PNG\r\n\x1a\n",
         "exr": b"\x76\x2f\x31\x01"}


class Daemon:
    def __init__(self, folder):
        self.socket = os.path.join(folder, "socket")
        self.run = subprocess.Popen(
            [GLINTD, "serve", "--listen", "127.0.0.1:0", "--unix", self.socket,
             "--size", "96x64", "--set", "quality.samples=2",
             "--set", "shadow.method=off"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        said = self.run.stdout.readline().decode()
        if not said.startswith("listening http://"):
            raise RuntimeError("glintd did not start: " + said)
        self.address = said.split("//")[1].strip().rstrip("/")

    def close(self):
        self.run.terminate()
        if self.run.wait(LIMIT) != 0:
            raise RuntimeError("glintd ended with %d" % self.run.returncode)


def glint(daemon, verb, *args, stdin=b"", unix=False):
    where = ["--unix", daemon.socket] if unix else \
        ["--connect", daemon.address]
    done = subprocess.run([GLINT, verb, *args, *where], input=stdin,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          timeout=LIMIT)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def equal(got, want):
    if got != want:
        raise AssertionError("got %r, want %r" % (got, want))


def test_state(d, _):
    code, out, err = glint(d, "get")
    equal((code, err), (0, ""))
    look = out.split()
    code, first, _ = glint(d, "set", "fibre.eta=1.7", "fibre.sigma_a=0.5",
                           "camera.eye=1,-2,3.25", unix=True)
    equal(code, 0)
    equal(glint(d, "get", "fibre.eta", "fibre.sigma_a", "camera.eye")[1],
          "fibre.eta=1.7\nfibre.sigma_a=0.5,0.5,0.5\ncamera.eye=1,-2,3.25\n")
    # All that `get` prints is what `set` takes, and leads back.
    code, second, err = glint(d, "set", *look)
    equal((code, err), (0, ""))
    equal(int(second) > int(first), True)
    equal(glint(d, "get")[1].split(), look)


def test_refusal(d, _):
    before = glint(d, "get")[1]
    code, out, err = glint(d, "set", "light.yaw=1", "fibre.beta_r=200")
    equal((code, out), (1, ""))
    equal(err, "glint: fibre.beta_r: 200 is not within [0.1, 60] deg\n")
    equal(glint(d, "get")[1], before)


def test_capture(d, folder):
    for end, magic in MAGIC.items():
        path = os.path.join(folder, "a." + end)
        code, _, err = glint(d, "capture", "size=40x30", "--out", path)
        equal((code, err), (0, ""))
        with open(path, "rb") as f:
            first = f.read()
        equal(first[:len(magic)], magic)
        # The same state gives the same bytes, also after other edits.
        equal(glint(d, "set", "light.yaw=40")[0], 0)
        code, _, _ = glint(d, "capture", "size=40x30", "light.yaw=0", "--out",
                           path)
        equal(code, 0)
        with open(path, "rb") as f:
            equal(f.read() == first, True)


def test_capture_fails(d, folder):
    path = os.path.join(folder, "b.png")
    for args in (["size=9000x9000"], ["depth=double"], ["fibre.eta=0"],
                 ["colour=red"]):
        code, out, err = glint(d, "capture", *args, "--out", path)
        equal((code, out, err.count("\n")), (1, "", 1))
        equal(os.path.exists(path), False)


def test_watch(d, folder):
    frames = os.path.join(folder, "frames")
    code, out, err = glint(d, "watch", "--count", "1", "--out", frames)
    equal((code, err), (0, ""))
    keys = [x.split("=")[0] for x in out.split()]
    equal(keys, ["id", "revision", "level", "samples", "ms", "bytes", "error"])
    names = os.listdir(frames)
    equal(len(names), 1)
    path = os.path.join(frames, names[0])
    equal("bytes=%d" % os.path.getsize(path) in out.split(), True)
    with open(path, "rb") as f:
        equal(f.read(3), MAGIC["jpg"])


def test_send(d, _):
    code, out, err = glint(d, "send", stdin=b"#1 ping\n#2 capture size=8x8 "
                           b"format=png\n#3 nonsense\n#4 get fibre.eta")
    equal((code, err), (1, "glint: 1 of 4 requests were refused\n"))
    lines = out.splitlines()
    for n, part in enumerate(('"ok":true,"tag":"1"', '"ok":true,"tag":"2"',
                              '"ok":false,"tag":"3"', '"ok":true,"tag":"4"')):
        if part not in lines[n]:
            raise AssertionError("%r is not in %r" % (part, lines[n]))


def main():
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        daemon = Daemon(folder)
        for name, test in list(globals().items()):
            if not name.startswith("test_"):
                continue
            label = "client and daemon: " + name[5:].replace("_", " ")
            try:
                test(daemon, folder)
                print("ok " + label)
            except Exception as e:  # a test that stumbles has failed
                print("  %s: %s\nnot ok %s" % (type(e).__name__, e, label))
                failed = 1
            sys.stdout.flush()
        daemon.close()
        print("took %.1f s" % (time.monotonic() - began))
    return failed


if __name__ == "__main__":
    sys.exit(main())
