#!/usr/bin/env python3
"""glint against a daemon that this test plays: what it sends, what it prints,
its exit status, and that a capture that fails leaves no file behind."""
import json
import os
import socket
import stat
import subprocess
import sys
import tempfile
import threading

GLINT = os.environ.get("GLINT", "build/glint")
LIMIT = 30  # seconds for one run of glint; each takes milliseconds


class Daemon:
    """Answers each request line by `answer(line)`: bytes, or None to close."""

    def __init__(self, answer, unix=None):
        self.answer, self.got = answer, []
        if unix:
            self.server = socket.socket(socket.AF_UNIX)
            self.server.bind(unix)
        else:
            self.server = socket.socket()
            self.server.bind(("127.0.0.1", 0))
        self.server.listen(4)
        self.server.settimeout(LIMIT)
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        try:
            conn, _ = self.server.accept()
        except OSError:
            return
        conn.settimeout(LIMIT)
        try:
            with conn:
                for line in conn.makefile("rb"):
                    self.got.append(line.decode().rstrip("\n"))
                    said = self.answer(self.got[-1])
                    if said is None:
                        return
                    conn.sendall(said)
        except OSError:
            pass

    def address(self):
        return "127.0.0.1:%d" % self.server.getsockname()[1]

    def close(self):
        self.server.close()
        self.thread.join(LIMIT)


def glint(*args, stdin=b"", env=None):
    done = subprocess.run([GLINT, *args], input=stdin, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, timeout=LIMIT,
                          env=dict(os.environ, **(env or {})))
    return done.returncode, done.stdout.decode("latin-1"), \
        done.stderr.decode("utf-8")


def talk(answer, *args, **kw):
    d = Daemon(answer)
    result = glint(*args, "--connect", d.address(), **kw)
    d.close()
    return result, d.got


def line(**keys):
    return json.dumps(keys, separators=(",", ":")).encode() + b"\n"


def frame(payload, reply=True, fmt="png", size=None, **more):
    head = {"id": 5, "revision": 3, "format": fmt, "width": 4, "height": 2,
            "x": 0, "y": 0, "bytes": len(payload) if size is None else size,
            "level": "final", "final": True, "samples": 64,
            "render_ms": 12.5, "encode_ms": 0.5, "stages": {"shade": 1}}
    head.update(more)
    keys = {"ok": True} if reply else {}
    return line(**keys, frame=head) + payload


def refusal(text="fibre.beta_r: 200 is not within [0.1, 60] deg"):
    return line(ok=False, error={"code": "range", "name": "x", "text": text})


def equal(got, want):
    if got != want:
        raise AssertionError("got %r, want %r" % (got, want))


def has(text, part):
    if part not in text:
        raise AssertionError("%r is not in %r" % (part, text))


def test_set():
    ok = lambda _: line(ok=True, revision=7)
    (code, out, err), got = talk(ok, "set", "fibre.eta=1.6", "light.yaw=30")
    equal((code, out, err), (0, "7\n", ""))
    equal(got, ["set fibre.eta=1.6 light.yaw=30"])
    (code, out, _), _ = talk(ok, "set", "a.b=1", "--json")
    equal((code, out), (0, '{"ok":true,"revision":7}\n'))
    (code, out, err), _ = talk(lambda _: refusal(), "set", "fibre.beta_r=200")
    equal((code, out), (1, ""))
    equal(err, "glint: fibre.beta_r: 200 is not within [0.1, 60] deg\n")


def test_quotes():
    ok = lambda _: line(ok=True, revision=1)
    _, got = talk(ok, "load", 'hair=a b"c\\d\n\x01\u20ac')
    equal(got, ['hair name="a b\\"c\\\\d\\n\\u0001\u20ac"'])
    _, got = talk(ok, "load", "env=a\\b=c")
    equal(got, ["env name=a\\b=c"])
    _, got = talk(ok, "set", "a.b=")
    equal(got, ['set a.b=""'])


def test_get():
    values = {"fibre.eta": 1.55, "fibre.sigma_a": [0.15, 0.25, 0.45],
              "fibre.alpha_tt": "auto", "view.head": True,
              "hair.use_colour": False, "output.format": "jpeg"}
    answer = lambda _: line(ok=True, revision=1, values=values)
    (code, out, _), got = talk(answer, "get", "fibre", "view.head")
    equal(got, ["get fibre view.head"])
    equal(code, 0)
    equal(out.split("\n"), ["fibre.eta=1.55", "fibre.sigma_a=0.15,0.25,0.45",
                            "fibre.alpha_tt=auto", "view.head=on",
                            "hair.use_colour=off", "output.format=jpeg", ""])
    # What is printed is what `set` takes.
    ok = lambda _: line(ok=True, revision=2)
    _, again = talk(ok, "set", *out.split())
    equal(again, ["set " + " ".join(out.split())])


def test_help_alone():
    code, out, err = glint("get", "--help", "fibre.beta_r")
    equal((code, err), (0, ""))
    has(out, "0.1 .. 60 deg")
    code, out, _ = glint("get", "--help")
    has(out, "\nfibre.eta ")
    code, out, _ = glint("get", "--markdown")
    has(out, "| `fibre.eta` | float | `1.55` | 1.05 .. 3 |")
    code, out, err = glint("get", "--help", "fibre.beta_q")
    equal((code, out), (1, ""))
    has(err, "did you mean fibre.beta_r?")
    equal(glint("--help")[0], 0)
    has(glint("capture", "--help")[1], "--out FILE")


def test_usage():
    for args in ([], ["paint"], ["set"], ["set", "x"], ["set", "=1"],
                 ["set", "A.b=1"], ["set", "a.b=1", "a.b=2"], ["load"],
                 ["load", "sky=x"], ["capture"], ["capture", "--out"],
                 ["capture", "--out", "x.gif"],
                 ["capture", "--out", "x.png", "format=exr"],
                 ["get", "--count", "1"], ["get", "--json=1"],
                 ["watch", "--count", "0"], ["watch", "--count", "x"],
                 ["send", "ping"], ["get", "--timeout", "-1"],
                 ["get", "--connect", "nohost"],
                 ["get", "--connect", "h:99999999"],
                 ["get", "--connect", "127.0.0.1:1", "--unix", "/x"]):
        code, out, err = glint(*args)
        if code != 2 or out or not err:
            raise AssertionError("%r: %r" % (args, (code, out, err)))


def test_unreachable():
    # A port that was free a moment ago.
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        port = s.getsockname()[1]
    code, _, err = glint("get", "--connect", "127.0.0.1:%d" % port)
    equal(code, 1)
    has(err, "no daemon at 127.0.0.1:%d (Connection refused); start one with "
             "`glintd serve`" % port)
    equal(err.count("\n"), 1)
    code, _, err = glint("get", "--unix", "/nonexistent/socket")
    equal(code, 1)
    has(err, "no daemon at /nonexistent/socket (No such file or directory)")


def test_unix(folder):
    path = os.path.join(folder, "s")
    d = Daemon(lambda _: line(ok=True, revision=9), unix=path)
    equal(glint("set", "a.b=1", "--unix", path)[:2], (0, "9\n"))
    d.close()


def test_token(folder):
    answer = lambda _: line(ok=True, revision=9)
    path = os.path.join(folder, "token")
    with open(path, "w") as f:
        f.write("s e\n")
    _, got = talk(answer, "set", "a.b=1", "--token-file", path)
    equal(got, ['hello token="s e"', "set a.b=1"])
    _, got = talk(answer, "set", "a.b=1", env={"GLINT_TOKEN": "abc"})
    equal(got, ["hello token=abc", "set a.b=1"])
    (code, _, err), got = talk(lambda _: refusal("the token is wrong"),
                               "set", "a.b=1", env={"GLINT_TOKEN": "abc"})
    equal((code, err), (1, "glint: the token is wrong\n"))


def test_capture(folder):
    payload = bytes(range(256)) * 3000  # several reads, every byte value
    path = os.path.join(folder, "a.png")
    (code, out, err), got = talk(lambda _: frame(payload), "capture",
                                 "size=4x2", "revision=2", "--out", path)
    equal((code, err), (0, ""))
    equal(got, ["capture format=png size=4x2 revision=2"])
    has(out, "revision 3, 4x2 png, 64 samples, 768000 bytes")
    with open(path, "rb") as f:
        equal(f.read() == payload, True)
    equal(os.listdir(folder), ["a.png"])
    mask = os.umask(0)
    os.umask(mask)
    equal(stat.S_IMODE(os.stat(path).st_mode), 0o666 & ~mask)


def test_capture_edits(folder):
    path = os.path.join(folder, "a.exr")
    answer = lambda x: line(ok=True, revision=41) if x.startswith("set") \
        else frame(b"exr", fmt="exr")
    (code, _, _), got = talk(answer, "capture", "fibre.eta=1.6", "depth=half",
                             "light.yaw=3", "--out", path)
    equal(code, 0)
    equal(got, ["set fibre.eta=1.6 light.yaw=3",
                "capture format=exr depth=half revision=41"])
    # A refused edit: nothing is captured.
    (code, _, err), got = talk(lambda _: refusal("no"), "capture", "a.b=1",
                               "--out", path)
    equal((code, err, got), (1, "glint: no\n", ["set a.b=1"]))


def test_capture_stdout():
    (code, out, err), _ = talk(lambda _: frame(b"\x89PNG\xff", fmt="png"),
                               "capture", "format=png", "--out", "-")
    equal((code, out), (0, "\x89PNG\xff"))
    has(err, "revision 3")


def test_capture_fails(folder):
    """Whatever goes wrong: status 1, one line, and the old file stays."""
    path = os.path.join(folder, "a.png")
    bad = {
        "refused": lambda _: refusal("render failed"),
        "closed at once": lambda _: None,
        "cut short": lambda _: frame(b"abc", size=1000),
        "no frame": lambda _: line(ok=True, revision=3),
        "another format": lambda _: frame(b"abc", fmt="exr"),
        "empty": lambda _: frame(b""),
        "huge": lambda _: frame(b"", size=1 << 40),
        "size missing": lambda _: frame(b"abc").replace(b'"bytes"', b'"b"'),
        "not JSON": lambda _: b"HTTP/1.1 400 Bad Request\r\n\r\n",
    }
    for name, answer in bad.items():
        for before in (None, b"old"):
            if before:
                with open(path, "wb") as f:
                    f.write(before)
            d = Daemon(lambda x: answer(x))
            if name == "cut short":
                d.answer = lambda x: answer(x) if len(d.got) == 1 else None
            # The daemon of "cut short" stays silent: the time limit ends it.
            code, out, err = glint("capture", "--out", path, "--timeout", "1",
                                   "--connect", d.address())
            d.close()
            if code != 1 or out or err.count("\n") != 1:
                raise AssertionError("%s: %r" % (name, (code, out, err)))
            equal(os.listdir(folder), ["a.png"] if before else [])
            if before:
                with open(path, "rb") as f:
                    equal(f.read(), before)
                os.unlink(path)
    (code, _, err), _ = talk(lambda _: frame(b"abc"), "capture", "--out",
                             os.path.join(folder, "none", "a.png"))
    equal(code, 1)
    has(err, "none/a.png: No such file or directory")


def test_capture_interrupted(folder):
    """A signal in the middle leaves nothing behind."""
    path = os.path.join(folder, "a.png")
    begun = threading.Event()
    d = Daemon(lambda _: (begun.set(), frame(b"abc", size=1000))[1])
    run = subprocess.Popen([GLINT, "capture", "--out", path, "--connect",
                            d.address()], stderr=subprocess.DEVNULL)
    begun.wait(LIMIT)
    for _ in range(1000):  # until the file beside has appeared
        if os.listdir(folder):
            break
        threading.Event().wait(0.01)
    equal(len(os.listdir(folder)), 1)
    run.terminate()
    equal(run.wait(LIMIT), -15)
    equal(os.listdir(folder), [])
    d.close()


def test_watch(folder):
    state = {"acks": 0}

    def answer(x):
        if x.startswith("stream"):
            return line(ok=True, revision=3) + \
                frame(b"one", False, "jpeg", id=1) + \
                line(event="failed", revision=3,
                     error={"code": "gpu", "name": "", "text": "lost"})
        state["acks"] += 1
        return line(ok=True) + frame(b"two", False, "jpeg", id=2,
                                     error={"metric": "rel_rmse",
                                            "value": 0.0123456})

    out_dir = os.path.join(folder, "frames")
    (code, out, err), got = talk(answer, "watch", "--count", "2", "--out",
                                 out_dir)
    equal((code, err), (0, "glint: lost\n"))
    equal(out, "id=1 revision=3 level=final samples=64 ms=13.0 bytes=3 "
               "error=-\nid=2 revision=3 level=final samples=64 ms=13.0 "
               "bytes=3 error=rel_rmse:0.01235\n")
    equal(got[:2], ["stream on window=2", "ack id=1"])
    equal(sorted(os.listdir(out_dir)), ["000001.jpg", "000002.jpg"])
    with open(os.path.join(out_dir, "000002.jpg"), "rb") as f:
        equal(f.read(), b"two")
    (code, _, err), _ = talk(lambda _: refusal("16 clients"), "watch")
    equal((code, err), (1, "glint: 16 clients\n"))


def test_send(folder):
    def answer(x):
        if "capture" in x:
            return frame(b"\n{\"ok\":\n\x00", fmt="png")
        return refusal() if "bad" in x else line(ok=True, tag=x[1:2])

    (code, out, err), got = talk(answer, "send", "--out", folder,
                                 stdin=b"#1 ping\n#2 capture\n#3 ping")
    equal((code, err), (0, ""))
    equal(got, ["#1 ping", "#2 capture", "#3 ping"])
    lines = [json.loads(x) for x in out.splitlines()]
    equal([x.get("tag") for x in lines], ["1", None, "3"])
    equal(lines[1]["frame"]["bytes"], 9)
    equal(os.listdir(folder), ["000005.png"])
    (code, out, err), _ = talk(answer, "send", stdin=b"bad\nping\n")
    equal((code, len(out.splitlines())), (1, 2))
    equal(err, "glint: 1 of 2 requests were refused\n")
    (code, out, err), _ = talk(answer, "send", stdin=b"")
    equal((code, out, err), (0, "", ""))
    (code, _, err), _ = talk(lambda _: None, "send", stdin=b"ping\n")
    equal((code, err), (1, "glint: the daemon closed the connection\n"))
    # More than a socket's buffers hold, both ways at once.
    text = b"#1 ping " + b"x" * 60000 + b"\n"
    (code, out, _), got = talk(lambda x: line(ok=True, echo=x), "send",
                               stdin=text * 200)
    equal((code, len(got), len(out.splitlines())), (0, 200, 200))


def test_links():
    try:
        out = subprocess.run(["readelf", "-d", GLINT], check=True,
                             stdout=subprocess.PIPE).stdout.decode()
    except (OSError, subprocess.CalledProcessError):
        return "no readelf"
    if os.environ.get("GLINT_SAN"):
        return "a sanitizer brings its own libraries"
    needed = {x.split("[")[1].split(".so")[0]
              for x in out.splitlines() if "NEEDED" in x}
    equal(needed - {"libc", "libm"}, set())
    return None


def main():
    failed = 0
    for name, test in sorted(globals().items()):
        if not name.startswith("test_"):
            continue
        label = "client: " + name[5:].replace("_", " ")
        try:
            with tempfile.TemporaryDirectory() as folder:
                why = test(folder) if test.__code__.co_argcount else test()
            print("skip %s: %s" % (label, why) if why else "ok " + label)
        except Exception as e:  # a test that stumbles has failed
            print("  %s: %s\nnot ok %s" % (type(e).__name__, e, label))
            failed = 1
        sys.stdout.flush()
    return failed


if __name__ == "__main__":
    sys.exit(main())
