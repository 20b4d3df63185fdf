#!/usr/bin/env python3
"""HTTP: the page, what is refused, and how long we listen."""
import socket

from glint_wire import PATIENCE, Daemon, equal, http, read_head, run, true


def request(d, target="/", method="GET", version="HTTP/1.1", **headers):
    lines = ["%s %s %s" % (method, target, version)]
    if "Host" not in headers:
        headers = {"Host": "127.0.0.1:%d" % d.port, **headers}
    lines += ["%s: %s" % (k.replace("_", "-"), v)
              for k, v in headers.items() if v is not None]
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def pages(d):
    for target, kind in (("/", "text/html"), ("/app.js", "text/javascript"),
                         ("/style.css", "text/css"), ("/?x=1", "text/html")):
        status, head, body = http(d.port, request(d, target))
        equal(status, 200, target)
        true(head["content-type"].startswith(kind), head)
        true(len(body) > 100, target)
        equal(len(body), int(head["content-length"]), target)
    status, head, body = http(d.port, request(d, "/", "HEAD"))
    equal((status, body), (200, b""), "HEAD")
    true(int(head["content-length"]) > 100, "HEAD names the length")


def every_answer_is_guarded(d):
    for raw in (request(d), request(d, "/nothing"), request(d, "/", "PUT"),
                request(d, Host="evil.example")):
        status, head, _ = http(d.port, raw)
        csp = head["content-security-policy"]
        true("default-src 'self'" in csp and "frame-ancestors 'none'" in csp,
             csp)
        equal(head["x-content-type-options"], "nosniff", status)
        equal(head["referrer-policy"], "no-referrer", status)
        equal(head["cross-origin-resource-policy"], "same-origin", status)


def refusals(d):
    big = "x" * 300
    for want, raw in (
            (404, request(d, "/nothing")),
            (404, request(d, "/../etc/passwd")),
            (404, request(d, "/index.html%00.js")),
            (404, request(d, "/" + big)),
            (405, request(d, "/", "PUT")),
            (405, request(d, "/", "DELETE")),
            (405, request(d, "/", "OPTIONS")),
            (405, request(d, "/ws", "POST")),
            (413, request(d, Content_Length=5)),
            (414, request(d, "/" + "x" * 2100)),
            (431, request(d, X_A="y" * 9000)),
            (431, request(d, **{"X_%d" % i: "y" for i in range(70)})),
            (426, request(d, "/ws")),
            (400, b"GET / HTTP/1.1\nHost: x\n\n"),
            (400, b"GET /\r\n\r\n"),
            (400, b"GET / HTTP/1.1\r\n Host: x\r\n\r\n"),
            (421, request(d, Host="evil.example:%d" % d.port)),
            (421, request(d, Host="127.0.0.1:1")),
            (421, request(d, Host="127.0.0.1")),
            (421, request(d, "/ws", Host="evil.example"))):
        status, head, _ = http(d.port, raw)
        equal(status, want, raw[:60])
        equal(head.get("connection", "").lower(), "close", raw[:60])
    _, head, _ = http(d.port, request(d, "/", "PUT"))
    equal(head["allow"], "GET, HEAD", "Allow")
    for host in ("localhost:%d", "LOCALHOST:%d", "[::1]:%d"):
        equal(http(d.port, request(d, Host=host % d.port))[0], 200, host)
    for origin, want in (("http://127.0.0.1:%d" % d.port, 200),
                         ("https://localhost:%d" % d.port, 200),
                         ("http://evil.example", 403), ("null", 403),
                         ("http://127.0.0.1", 403)):
        equal(http(d.port, request(d, Origin=origin))[0], want, origin)


def keep_alive_and_pipelining(d):
    with socket.create_connection(d.address, PATIENCE) as s:
        f = s.makefile("rb")
        s.sendall(request(d, "/style.css") * 3 + request(d, "/", "HEAD"))
        for _ in range(3):
            status, head = read_head(f)
            equal(status, 200, "status")
            f.read(int(head["content-length"]))
        equal(read_head(f)[0], 200, "HEAD")
        s.sendall(request(d, "/style.css", Connection="close"))
        status, head = read_head(f)
        equal(head["connection"].lower(), "close", "told")
        f.read(int(head["content-length"]))
        equal(f.read(1), b"", "closed")


def a_hundred_requests_are_enough(d):
    with socket.create_connection(d.address, PATIENCE) as s:
        f = s.makefile("rb")
        for i in range(100):
            s.sendall(request(d, "/style.css", "HEAD"))
            equal(read_head(f)[0], 200, "request %d" % i)
        equal(f.read(1), b"", "closed after the hundredth")


def split_heads(d):
    with socket.create_connection(d.address, PATIENCE) as s:
        for byte in request(d, "/style.css"):
            s.sendall(bytes([byte]))
        equal(read_head(s.makefile("rb"))[0], 200, "status")


if __name__ == "__main__":
    run([pages, every_answer_is_guarded, refusals, keep_alive_and_pipelining,
         a_hundred_requests_are_enough, split_heads], Daemon())
