"""A small client of glintd, written from protocol/PROTOCOL.md, and what the
tests beside it share: starting a daemon, a tiny groom, counting cases."""
import atexit
import base64
import json
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
GLINTD = os.environ.get("GLINTD", os.path.join(HERE, "../../build/glintd"))
SANITIZED = bool(os.environ.get("GLINT_SAN"))
# Every wait of the tests ends after this; a sanitized daemon on a busy machine
# needs about ten times as long as a plain one.
PATIENCE = 60 if SANITIZED else 20
# Dozens of daemons on few cores: none compiles ahead but test_warm.py's.
os.environ.setdefault("GLINT_WARM", "0")


class Refused(Exception):
    def __init__(self, reply):
        super().__init__(reply["error"]["text"])
        self.reply = reply
        self.code = reply["error"]["code"]
        self.name = reply["error"]["name"]
        self.text = reply["error"]["text"]


class Line:
    """A connection that speaks the line protocol."""

    def __init__(self, address, receive_buffer=None):
        family = socket.AF_UNIX if isinstance(address, str) else socket.AF_INET
        self.socket = socket.socket(family)
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF,
                                   receive_buffer)
        self.socket.settimeout(PATIENCE)
        self.socket.connect(address)
        self.file = self.socket.makefile("rb")
        self.frames = []   # that came while a reply was waited for
        self.notices = []

    def send(self, line):
        self.raw(line.encode() + b"\n")

    def raw(self, data):
        self.socket.sendall(data)

    def message(self):
        """The next message: its JSON, and bytes where it is a frame.  None at
        the end of the stream."""
        line = self.file.readline()
        if not line:
            return None
        if not line.endswith(b"\n"):
            raise AssertionError("half a line: %r" % line)
        head = json.loads(line)
        body = None
        if "frame" in head:
            body = self.file.read(head["frame"]["bytes"])
            if len(body) != head["frame"]["bytes"]:
                raise AssertionError("a frame was cut short")
        return head, body

    def reply(self):
        """The next reply; frames and notices before it are kept."""
        while True:
            got = self.message()
            if got is None:
                raise EOFError("the server closed the connection")
            head, body = got
            if "ok" in head:
                return head, body
            if "frame" in head:
                self.frames.append((head["frame"], body))
            else:
                self.notices.append(head)

    def ask_whole(self, line):
        self.send(line)
        return self.reply()

    def ask(self, line):
        head, _ = self.ask_whole(line)
        if not head["ok"]:
            raise Refused(head)
        return head

    def refused(self, line):
        """The error of a request that must fail."""
        try:
            head = self.ask(line)
        except Refused as why:
            return why
        raise AssertionError("not refused: %s -> %s" % (line[:80], head))

    def capture(self, options=""):
        head, body = self.ask_whole(("capture " + options).strip())
        if not head["ok"]:
            raise Refused(head)
        return head["frame"], body

    def frame(self):
        """The next streamed frame."""
        if self.frames:
            return self.frames.pop(0)
        while True:
            got = self.message()
            if got is None:
                raise EOFError("the server closed the connection")
            head, body = got
            if "ok" not in head and "frame" in head:
                return head["frame"], body
            raise AssertionError("expected a frame, got %s" % head)

    def silent(self, seconds):
        """True when nothing comes for so long."""
        if self.frames:
            return False
        return not select.select([self.socket], [], [], seconds)[0]

    def vanish(self):
        """Gone without a word: the peer sees a reset."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER,
                               struct.pack("ii", 1, 0))
        self.close()

    def ended(self):
        """True when the server has closed the stream."""
        try:
            return self.file.read(1) == b""
        except ConnectionResetError:
            return True

    def close(self):
        self.file.close()
        self.socket.close()


class WebSocket:
    """The client's side of RFC 6455, with every freedom to misbehave."""

    def __init__(self, port, headers=None, path="/ws"):
        self.socket = socket.create_connection(("127.0.0.1", port), PATIENCE)
        self.file = self.socket.makefile("rb")
        key = base64.b64encode(os.urandom(16)).decode()
        head = {"Host": "127.0.0.1:%d" % port, "Upgrade": "websocket",
                "Connection": "Upgrade", "Sec-WebSocket-Key": key,
                "Sec-WebSocket-Version": "13"}
        head.update(headers or {})
        self.key = head["Sec-WebSocket-Key"]
        text = "GET %s HTTP/1.1\r\n" % path + "".join(
            "%s: %s\r\n" % item for item in head.items() if item[1] is not None)
        self.socket.sendall(text.encode() + b"\r\n")
        self.status, self.headers = read_head(self.file)

    def send(self, opcode, payload=b"", fin=True, mask=b"abcd", rsv=0,
             length=None):
        size = len(payload) if length is None else length
        head = bytes([(0x80 if fin else 0) | rsv << 4 | opcode])
        bit = 0x80 if mask else 0
        if size < 126:
            head += bytes([bit | size])
        elif size < 65536:
            head += bytes([bit | 126]) + struct.pack(">H", size)
        else:
            head += bytes([bit | 127]) + struct.pack(">Q", size)
        if mask:
            head += mask
            payload = bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        self.socket.sendall(head + payload)

    def text(self, line):
        self.send(1, line.encode())

    def receive(self):
        """(opcode, payload); None at the end of the stream."""
        head = self.file.read(2)
        if len(head) < 2:
            return None
        if head[0] & 0x70 or not head[0] & 0x80 or head[1] & 0x80:
            raise AssertionError("bad frame head %r" % head)
        size = head[1]
        if size == 126:
            size = struct.unpack(">H", self.file.read(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self.file.read(8))[0]
        return head[0] & 15, self.file.read(size)

    def ask(self, line):
        self.text(line)
        while True:
            opcode, payload = self.receive()
            if opcode == 1:
                return json.loads(payload)

    def close_code(self):
        """The code with which the server closes; then the stream must end."""
        while True:
            got = self.receive()
            if got is None:
                return None
            if got[0] == 8:
                break
        code = struct.unpack(">H", got[1][:2])[0] if len(got[1]) >= 2 else 1005
        self.send(8, got[1][:2])
        if self.file.read(1) != b"":
            raise AssertionError("bytes after the close frame")
        return code

    def close(self):
        self.file.close()
        self.socket.close()


def read_head(file):
    status = file.readline()
    if not status:
        return None, {}
    headers = {}
    while True:
        line = file.readline().strip()
        if not line:
            return int(status.split()[1]), headers
        name, value = line.split(b":", 1)
        headers[name.decode().lower()] = value.strip().decode()


def http(port, request):
    """Sends bytes; (status, headers, body) of the answer, body to its end."""
    with socket.create_connection(("127.0.0.1", port), PATIENCE) as s:
        s.sendall(request)
        file = s.makefile("rb")
        status, headers = read_head(file)
        body = b""
        if not request.startswith(b"HEAD") and status is not None:
            body = file.read(int(headers.get("content-length", 0)))
        return status, headers, body


def write_groom(path, strands=300, points=8):
    """A tuft of hair: short arcs that stand on a disc and hang over."""
    import math
    head = struct.pack("<4sIIIIff3f88s", b"HAIR", strands, strands * points, 2,
                       points - 1, 0.05, 0.0, 1, 1, 1, b"")
    floats = []
    for s in range(strands):
        turn, out = 2.399963 * s, math.sqrt((s + 0.5) / strands)
        for p in range(points):
            t = p / (points - 1)
            r = 2 * out + 3 * t * out
            floats += [r * math.cos(turn), r * math.sin(turn),
                       3 * t - 6 * t * t]
    with open(path, "wb") as f:
        f.write(head + struct.pack("<%df" % len(floats), *floats))


class Daemon:
    """A running glintd with a tiny groom and picture."""

    def __init__(self, *options, size="96x64", samples=4, listen="127.0.0.1:0",
                 stderr=subprocess.PIPE):
        self.folder = tempfile.TemporaryDirectory(prefix="glint-wire-")
        self.root = os.path.join(self.folder.name, "root")
        os.mkdir(self.root)
        self.groom = os.path.join(self.root, "tuft.hair")
        write_groom(self.groom)
        self.unix = os.path.join(self.folder.name, "socket")
        command = [GLINTD, "serve", "--listen", listen, "--hair", self.groom,
                   "--root", self.root, "--unix", self.unix, "--size", size,
                   "--set", "quality.samples=%d" % samples,
                   # Few lights: the fit is not what these tests are about.
                   "--set", "shadow.method=off",  # pictures are not the point
                   # No frame comes twice, with what is known of it.
                   "--set", "quality.error_places=0",
                   # Frames depend on no clock; drafts: test_draft.py.
                   "--set", "quality.draft_ms=0",
                   "--set", "sky.lights=4"] + list(options)
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE,
                                        stderr=stderr)
        atexit.register(self.kill)  # a failed case leaves no daemon behind
        line = self.line()
        if not line.startswith("listening http://"):
            err = (self.process.stderr.read().decode()
                   if self.process.stderr else "")
            raise AssertionError("glintd did not start: %r %s" % (line, err))
        self.port = int(line.rsplit(":", 1)[1].strip("/\n"))
        self.address = ("127.0.0.1", self.port)

    def line(self):
        out = self.process.stdout
        if not select.select([out], [], [], PATIENCE)[0]:
            self.process.kill()
            raise AssertionError("glintd said nothing in time")
        return out.readline().decode()

    def connect(self, **options):
        return Line(self.address, **options)

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def stop(self, how=signal.SIGTERM):
        """Its exit status and what it said on stderr."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            _, err = self.process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.communicate()
            raise AssertionError("glintd did not end in time")
        finally:
            self.folder.cleanup()
        return self.process.returncode, (err or b"").decode()


def alone(daemon):
    """A connection, once all others are gone and leave nothing behind."""
    c = daemon.connect()
    end = time.monotonic() + PATIENCE
    while c.ask("stats")["clients"] > 1 and time.monotonic() < end:
        time.sleep(0.05)
    s = c.ask("stats")
    equal((s["clients"], s["viewers"], s["captures_waiting"]), (1, 0, 0),
          "nothing is left")
    return c


def baseline(daemon):
    """The request that sets every parameter to what it is now."""
    c = daemon.connect()
    values = c.ask("get")["values"]
    c.close()
    return "set " + " ".join("%s=%s" % (k, written(v))
                             for k, v in values.items())


def written(v):
    """A value out of `get` as `set` takes it."""
    if isinstance(v, list):
        return ",".join(repr(x) for x in v)
    if isinstance(v, bool):
        return "on" if v else "off"
    return v if isinstance(v, str) else repr(v)


def run(cases, daemon=None):
    """Runs each case(daemon), prints its verdict, ends the process.  Each
    begins with the parameters and the groom that the daemon began with."""
    bad = 0
    begin = [baseline(daemon), "hair name=tuft.hair",
             "env name=builtin:studio"] if daemon else []
    for case in cases:
        name = case.__name__
        began = time.monotonic()
        try:
            if daemon:
                c = daemon.connect()
                for line in begin:
                    c.ask(line)
                c.close()
            case(daemon) if daemon else case()
            print("ok %s  (%.1f s)" % (name, time.monotonic() - began))
        except Exception as why:  # any failure is this case's own
            import traceback
            traceback.print_exc(file=sys.stdout)
            print("not ok %s  %s" % (name, why))
            bad += 1
        sys.stdout.flush()
        if daemon and daemon.process.poll() is not None:
            print("not ok daemon  it ended with %s" % daemon.process.returncode)
            bad += 1
            break
    if daemon:
        code, err = daemon.stop()
        ok = code == 0
        print("%s daemon_ends_well" % ("ok" if ok else "not ok"))
        if not ok or err:
            print("  exit %s, stderr: %s" % (code, err))
        bad += not ok
    sys.exit(1 if bad else 0)


def equal(got, want, what=""):
    if got != want:
        raise AssertionError("%s: got %r, want %r" % (what, got, want))


def true(ok, what):
    if not ok:
        raise AssertionError(what)
