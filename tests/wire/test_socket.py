#!/usr/bin/env python3
"""WebSocket: the handshake, framing, close codes, requests and frames."""
import base64
import hashlib
import json
import struct
import time

from glint_wire import PATIENCE, Daemon, WebSocket, equal, run, true


def handshake(d):
    w = WebSocket(d.port)
    equal(w.status, 101, "status")
    want = base64.b64encode(hashlib.sha1(
        (w.key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest())
    equal(w.headers["sec-websocket-accept"], want.decode(), "accept")
    true("sec-websocket-extensions" not in w.headers, "no extensions")
    equal(w.ask("#w ping")["tag"], "w", "a request")
    w.close()


def handshakes_refused(d):
    for want, headers in (
            (426, {"Sec-WebSocket-Version": "8"}),
            (400, {"Sec-WebSocket-Key": "short"}),
            (400, {"Sec-WebSocket-Key": None}),
            (403, {"Origin": "http://evil.example"}),
            (403, {"Origin": "null"}),
            (421, {"Host": "evil.example:%d" % d.port})):
        w = WebSocket(d.port, headers)
        equal(w.status, want, headers)
        w.close()
    w = WebSocket(d.port, {"Origin": "http://localhost:%d" % d.port})
    equal(w.status, 101, "our own origin")
    w.close()


def fragments(d):
    w = WebSocket(d.port)
    w.send(1, b"#f pi", fin=False)
    w.send(9, b"in between")
    w.send(0, b"ng echo=", fin=False)
    w.send(0, b"", fin=False)
    w.send(0, b"\xc3", fin=False)
    w.send(0, b"\xa9")
    equal(w.receive(), (10, b"in between"), "the pong comes first")
    got = json.loads(w.receive()[1])
    equal((got["tag"], got["echo"]), ("f", "\u00e9"), "the whole message")
    w.close()


def masks_and_sizes(d):
    w = WebSocket(d.port)
    for mask in (b"\0\0\0\0", b"\xff\xff\xff\xff", b"\x01\x80\x7f\xfe"):
        w.send(1, b"#m ping", mask=mask)
        equal(json.loads(w.receive()[1])["tag"], "m", mask)
    for size in (100, 125, 126, 127, 1000, 65536):
        line = b"ping echo=" + b"x" * (size - 10)
        w.send(1, line)
        opcode, payload = w.receive()
        equal(opcode, 1, "text")
        equal(len(json.loads(payload)["echo"]), size - 10, size)
    for size in (0, 125):
        w.send(9, b"p" * size)
        equal(w.receive(), (10, b"p" * size), "pong")
    w.send(10, b"unasked")  # a pong nobody asked for is ignored
    equal(w.ask("#p ping")["tag"], "p", "still open")
    w.close()


def close_codes(d):
    for want, send in (
            (1002, lambda w: w.send(1, b"ping", mask=None)),
            (1002, lambda w: w.send(1, b"ping", rsv=4)),
            (1002, lambda w: w.send(3, b"")),
            (1002, lambda w: w.send(11, b"")),
            (1002, lambda w: w.send(9, b"x", fin=False)),
            (1002, lambda w: w.send(9, b"x" * 126)),
            (1002, lambda w: w.send(0, b"x")),
            (1002, lambda w: (w.send(1, b"a", fin=False), w.send(1, b"b"))),
            (1002, lambda w: w.send(8, b"x")),
            (1002, lambda w: w.send(8, struct.pack(">H", 999))),
            (1003, lambda w: w.send(2, b"binary")),
            (1007, lambda w: w.send(1, b"ping echo=\xff")),
            (1007, lambda w: w.send(1, b"\xed\xa0\x80")),
            (1008, lambda w: [w.send(1 if i == 0 else 0, b"x", fin=False)
                              for i in range(1026)]),
            (1009, lambda w: w.send(1, b"", length=65537)),
            (1009, lambda w: w.send(1, b"", length=1 << 40)),
            (1009, lambda w: (w.send(1, b"x" * 60000, fin=False),
                              w.send(0, b"", length=6000))),
            (1000, lambda w: w.send(8, struct.pack(">H", 1000) + b"bye")),
            (1005, lambda w: w.send(8, b"")),
            (1000, lambda w: (w.text("quit"), w.receive()))):
        w = WebSocket(d.port)
        send(w)
        equal(w.close_code(), want, "code")
        w.close()


def errors_do_not_close(d):
    w = WebSocket(d.port)
    got = w.ask("#e set fibre.beta_r=200")
    equal((got["tag"], got["error"]["code"]), ("e", "range"), "error")
    equal(w.ask("ping\n")["error"]["code"], "syntax", "a line end inside")
    equal(w.ask("GET / HTTP/1.1")["ok"], False, "it is only a bad line here")
    equal(w.ask("#k ping")["tag"], "k", "still open")
    w.close()


def split_frame(payload):
    line, body = payload.split(b"\n", 1)
    head = json.loads(line)
    equal(len(body), head["frame"]["bytes"], "bytes")
    return head, body


def captures_and_frames(d):
    w = WebSocket(d.port)
    w.text("#c capture format=jpeg")
    opcode, payload = w.receive()
    equal(opcode, 2, "binary")
    head, body = split_frame(payload)
    equal((head["ok"], head["tag"]), (True, "c"), "reply")
    true(body.startswith(b"\xff\xd8"), "jpeg")
    equal(w.ask("capture format=bmp")["error"]["code"], "type", "a text")
    equal(w.ask("stream on quality=50")["ok"], True, "stream")
    w.text("set light.yaw=44 seq=5")
    end = time.monotonic() + PATIENCE
    seen, r = None, None
    while time.monotonic() < end:
        opcode, payload = w.receive()
        if opcode == 1:
            got = json.loads(payload)
            r = got.get("revision", r)
            continue
        head, _ = split_frame(payload)
        true("ok" not in head, "a streamed frame answers nothing")
        seen = head["frame"]
        w.text("ack id=%d" % seen["id"])
        if seen.get("seq") == 5 and seen["final"]:
            break
    equal((seen["seq"], seen["revision"]), (5, r), "the edit is shown")
    w.close()


def requests_wait_for_a_capture(d):
    """Pings are answered meanwhile, requests after it, in order."""
    w = WebSocket(d.port)
    r = w.ask("get fibre.eta")["revision"]
    w.text("#a capture format=jpeg revision=%d" % (r + 1))
    w.send(9, b"alive")
    equal(w.receive(), (10, b"alive"), "the pong")
    w.text("#b ping")
    w.text("#c ping")
    w.send(9, b"later")
    c = d.connect()
    c.ask("set light.yaw=1")
    got = [w.receive() for _ in range(4)]
    equal(split_frame(got[0][1])[0]["tag"], "a", "first")
    equal([json.loads(x[1])["tag"] for x in got[1:3]], ["b", "c"], "then")
    equal(got[3], (10, b"later"), "what came behind them")
    w.close()
    c.close()


def byte_by_byte(d):
    w = WebSocket(d.port)
    payload = bytes(b ^ b"mask"[i % 4] for i, b in enumerate(b"#s ping"))
    for b in b"\x81" + bytes([0x80 | 7]) + b"mask" + payload:
        w.socket.sendall(bytes([b]))
        time.sleep(0.001)
    equal(json.loads(w.receive()[1])["tag"], "s", "the reply")
    w.close()


def many_pings(d):
    w = WebSocket(d.port)
    for i in range(200):
        w.send(9, b"%d" % i)
    last = None
    for _ in range(200):
        last = w.receive()[1]
        if last == b"199":
            break
    equal(last, b"199", "the latest is answered")
    w.close()


if __name__ == "__main__":
    run([handshake, handshakes_refused, fragments, masks_and_sizes, close_codes,
         errors_do_not_close, captures_and_frames, requests_wait_for_a_capture,
         byte_by_byte, many_pings], Daemon())
