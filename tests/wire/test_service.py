#!/usr/bin/env python3
"""The daemon as a whole: start, ports, signals, limits, tokens."""
import os
import resource
import signal
import socket
import subprocess
import tempfile
import threading
import time

from glint_wire import (GLINTD, PATIENCE, SANITIZED, Daemon, Line, WebSocket,
                        equal, http, run, true)


def fails(*options, code=1):
    """glintd must fail with one line on stderr; the line."""
    done = subprocess.run([GLINTD] + list(options), capture_output=True,
                          timeout=PATIENCE)
    err = done.stderr.decode()
    equal(done.returncode, code, "%s: %s" % (options, err))
    equal(err.count("\n"), 1, "one line: %r" % err)
    equal(done.stdout, b"", "nothing on stdout")
    return err


def refused_starts():
    true("Usage" not in fails("serve", "--nonsense", code=2), "usage")
    for options, word, code in (
            (["fly"], "fly", 2),
            (["serve", "--listen"], "--listen", 2),
            (["serve", "--listen", "localhost"], "HOST:PORT", 2),
            (["serve", "--listen", "127.0.0.1:99999"], "65535", 2),
            (["serve", "--listen", "example.org:1"], "example.org", 2),
            (["serve", "--set", "fibre.eta=9"], "[1.05, 3]", 2),
            (["serve", "--set", "fibre.eat=1"], "fibre.eta", 2),
            (["serve", "--size", "10"], "10", 2),
            (["serve", "--size", "9000x10"], "8192", 2),
            (["serve", "--out", "x"], "--out", 2),
            (["serve", "extra"], "extra", 2),
            (["serve", "--listen", "0.0.0.0:0"], "--token-file", 1),
            (["serve", "--listen", "[::]:0"], "--token-file", 1)):
        true(word in fails(*options, code=code), "%s: %s" % (options, word))
    with tempfile.TemporaryDirectory() as folder:
        for options, word in (
                (["--hair", "builtin:wig"], "wig"),
                (["--hair", folder + "/none.hair"], "none.hair"),
                (["--env", "builtin:none"], "none"),
                (["--root", folder + "/nowhere"], "nowhere"),
                (["--token-file", folder + "/none"], "none"),
                (["--unix", folder + "/" + "x" * 200], "longer")):
            true(word in fails("serve", "--listen", "127.0.0.1:0", *options),
                 "%s: %s" % (options, word))


def help_and_version():
    for options, word in ((["--help"], "serve"), (["serve", "--help"],
                          "--listen"), (["--version"], "glintd "),
                          (["info", "--params"], "fibre.eta")):
        done = subprocess.run([GLINTD] + options, capture_output=True,
                              timeout=PATIENCE)
        equal((done.returncode, done.stderr), (0, b""), options)
        true(word in done.stdout.decode(), options)


def port_in_use():
    d = Daemon()
    err = fails("serve", "--listen", "127.0.0.1:%d" % d.port)
    true(str(d.port) in err and "in use" in err, err)
    err = fails("serve", "--listen", "127.0.0.1:0", "--unix", d.unix)
    true("in use" in err, err)
    c = d.connect()
    c.ask("ping")  # the first one is unharmed
    c.close()
    equal(d.stop()[0], 0, "exit status")


def ends_on_sigterm():
    for how in (signal.SIGTERM, signal.SIGINT):
        d = Daemon()
        unix = d.unix
        line, idle = d.connect(), d.connect()
        ws = WebSocket(d.port)
        line.ask("stream on")
        line.frame()
        d.process.send_signal(how)
        equal(ws.close_code(), 1001, "going away")
        while line.message():
            pass  # frames that were under way
        true(idle.ended(), "closed")
        code, err = d.stop()
        equal((code, err), (0, ""), "exit status, stderr")
        true(not os.path.exists(unix), "the socket file is gone")


def ends_while_rendering():
    d = Daemon("--set", "quality.samples=4096", size="480x320")
    c = d.connect()
    c.send("capture format=png")
    time.sleep(0.3)
    began = time.monotonic()
    equal(d.stop()[0], 0, "exit status")
    took = time.monotonic() - began
    true(took < (30 if SANITIZED else 6), "it took %.1f s" % took)


def stale_unix_sockets_are_replaced():
    with tempfile.TemporaryDirectory() as folder:
        path = folder + "/s"
        s = socket.socket(socket.AF_UNIX)
        s.bind(path)
        s.close()
        d = Daemon("--unix", path)
        c = Line(path)
        c.ask("ping")
        c.close()
        equal(d.stop()[0], 0, "exit status")
        with open(path, "w") as f:
            f.write("a file")
        fails("serve", "--listen", "127.0.0.1:0", "--unix", path)
        true(os.path.exists(path), "no file is removed")


def tokens():
    token = "0123456789abcdef-TOKEN"
    with tempfile.TemporaryDirectory() as folder:
        path = folder + "/token"
        with open(path, "w") as f:
            f.write("short\n")
        fails("serve", "--token-file", path)
        with open(path, "w") as f:
            f.write(token + "\n")
        d = Daemon("--token-file", path)
        c = d.connect()
        c.ask("ping")
        for line in ("get", "set fibre.eta=1.6", "capture", "hello", "stats",
                     "stream on", "hair name=builtin:bob"):
            equal(c.refused(line).code, "token", line)
        c.ask("hello token=" + token)
        c.ask("set fibre.eta=1.6")
        c.close()
        for wrong in (token[:-1], token + "x", "x" * len(token), '""'):
            c = d.connect()
            equal(c.refused("hello token=" + wrong).code, "token", wrong)
            true(c.ended(), "one guess each")
            c.close()
        c = Line(d.unix)
        c.ask("get fibre.eta")  # its owner needs none
        c.close()
        w = WebSocket(d.port)
        equal(w.ask("get fibre.eta")["error"]["code"], "token", "WebSocket")
        true(w.ask("hello token=" + token)["ok"], "with it")
        w.close()
        w = WebSocket(d.port)
        equal(w.ask("hello token=wrong")["error"]["code"], "token", "a guess")
        equal(w.close_code(), 1008, "close code")
        w.close()
        equal(d.stop()[0], 0, "exit status")


def connection_limit():
    d = Daemon("--max-connections", "3")
    three = [d.connect() for _ in range(3)]
    for c in three:
        c.ask("ping")
    c = d.connect()
    c.send("ping")
    head, _ = c.reply()
    equal(head["error"]["code"], "limit", "the fourth is told")
    true(c.ended(), "and closed")
    c.close()
    status, head, _ = http(d.port, b"GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n"
                           % d.port)
    equal(status, 503, "over HTTP")
    true("retry-after" in head, "Retry-After")
    three.pop().close()
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        c = d.connect()
        c.send("ping")
        if c.reply()[0]["ok"]:
            break
        c.close()
        time.sleep(0.05)
    c.ask("ping")
    for x in three + [c]:
        x.close()
    equal(d.stop()[0], 0, "exit status")


def descriptors_run_out():
    """No spinning, no death; service again when there are some."""
    d = Daemon(stderr=subprocess.DEVNULL)
    pid = d.process.pid
    used = len(os.listdir("/proc/%d/fd" % pid))
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (used + 4, used + 4))
    many = []
    for _ in range(12):
        s = socket.create_connection(d.address, PATIENCE)
        many.append(s)
    time.sleep(0.3)
    before = cpu_seconds(pid)
    time.sleep(0.5)
    true(cpu_seconds(pid) - before < 0.2, "it does not spin")
    for s in many:
        s.close()
    time.sleep(0.3)
    c = d.connect()
    c.ask("ping")
    c.close()
    equal(d.stop()[0], 0, "exit status")


def cpu_seconds(pid):
    with open("/proc/%d/stat" % pid) as f:
        fields = f.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def idle_clients_cost_little():
    d = Daemon()
    c = d.connect()
    c.ask("stats")
    before = resident(d.process.pid)
    many = [d.connect() for _ in range(500)]
    for m in many:
        m.send("ping")
    for m in many:
        m.reply()
    each = (resident(d.process.pid) - before) / len(many)
    # An allocator under a sanitizer keeps freed memory on purpose.
    true(SANITIZED or each < 16384, "%d bytes each" % each)
    before = cpu_seconds(d.process.pid)
    time.sleep(0.5)
    true(cpu_seconds(d.process.pid) - before < 0.1, "idle is idle")
    for m in many:
        m.close()
    c.close()
    equal(d.stop()[0], 0, "exit status")


def resident(pid):
    with open("/proc/%d/statm" % pid) as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Aside:
    """A case that mostly waits: it runs beside the others, and is judged when
    its turn comes."""

    def __init__(self, case):
        self.case, self.why = case, None
        self.thread = threading.Thread(target=self.work, daemon=True)
        self.thread.start()

    def work(self):
        try:
            self.case()
        except Exception as why:
            self.why = why

    def judge(self):
        self.thread.join(3 * PATIENCE)
        true(not self.thread.is_alive(), "it did not end")
        if self.why:
            raise self.why


def stall():
    d = Daemon()
    c = d.connect(receive_buffer=4096)
    other = d.connect()
    # A capture of 33 MB fits into no socket buffer.
    c.send("set image.width=2048 image.height=1024 quality.samples=1")
    c.send("capture format=exr depth=float")
    c.send("capture format=exr depth=float")
    began = time.monotonic()
    while other.ask("stats")["clients"] > 1:
        true(time.monotonic() - began < 15 + PATIENCE, "dropped in time")
        time.sleep(0.2)
    true(time.monotonic() - began > 9, "but not too soon")
    other.ask("ping")
    c.close()
    other.close()
    equal(d.stop()[0], 0, "exit status")


def trickle():
    """However many bytes trickle in: 10 s for a head in all."""
    d = Daemon()
    began = time.monotonic()
    with socket.create_connection(d.address, PATIENCE) as s:
        s.sendall(b"GET / HTTP/1.1\r\n")
        s.settimeout(0.5)
        data = b""
        while time.monotonic() - began < 15 and not data:
            try:
                s.sendall(b"X: y\r\n")
                data = s.recv(100)
            except socket.timeout:
                pass
    took = time.monotonic() - began
    true(data.startswith(b"HTTP/1.1 408"), data)
    true(9 <= took <= 14, "after %.1f s" % took)
    equal(d.stop()[0], 0, "exit status")


def a_reader_that_stalls_is_dropped():
    stalling.judge()


def heads_that_trickle_are_cut():
    trickling.judge()


def big_captures_arrive_whole():
    d = Daemon(samples=1)
    c = d.connect(receive_buffer=65536)
    f, body = c.capture("format=exr depth=float size=1600x900")
    equal(len(body), f["bytes"], "bytes")
    equal((f["width"], f["height"]), (1600, 900), "size")
    g, again = c.capture("format=exr depth=float size=1600x900")
    true(again == body, "twice the same")
    c.close()
    equal(d.stop()[0], 0, "exit status")


if __name__ == "__main__":
    stalling, trickling = Aside(stall), Aside(trickle)
    run([refused_starts, help_and_version, port_in_use, ends_on_sigterm,
         ends_while_rendering, stale_unix_sockets_are_replaced, tokens,
         connection_limit, descriptors_run_out, idle_clients_cost_little,
         big_captures_arrive_whole,
         a_reader_that_stalls_is_dropped, heads_that_trickle_are_cut])
