#!/usr/bin/env python3
"""The line protocol's framing: what is cut where, and what ends a connection."""
import json
import socket
import time

from glint_wire import Daemon, equal, run, true


def malformed_lines_do_not_close(d):
    c = d.connect()
    for line in (b" ping", b"ping ", b"ping  x", b"Ping", b"#", b"# ping",
                 b"#a\x01 ping", b"set fibre.eta", b"set fibre.eta=",
                 b"set =1", b"set fibre.eta=1.6 x", b"set fibre.eta=1.6 "
                 b"fibre.eta=1.7", b'ping echo="open', b'ping echo="\\q"',
                 b'ping echo="\\ud800"', b'ping echo="\\u0000"', b"ping\techo=1",
                 b"set fibre.eta=1,6", b"set fibre.eta=0x2", b"set fibre.eta=nan",
                 b"set fibre.eta=1e999", b"set fibre.eta=.5", b"\xff\xfe",
                 b"ping echo=\xc0\x80", b"ping\x00", b"", b"{\"verb\":1}",
                 b"#" + b"t" * 65 + b" ping", b"v" * 65,
                 b"get" + b" fibre" * 129):
        c.raw(line + b"\n")
        head, _ = c.reply()
        true(not head["ok"], line)
        true(head["error"]["code"] in ("syntax", "type", "range", "limit",
                                       "unknown"), "%r %s" % (line, head))
        true(head["error"]["text"], line)
    equal(c.ask("#still ping")["tag"], "still", "still open")
    c.close()


def errors_carry_the_tag(d):
    c = d.connect()
    for line in ("#t nonsense", "#t ping  x", "#t set fibre.eta=9",
                 "#t capture size=0x0"):
        equal(c.refused(line).reply["tag"], "t", line)
    c.close()


def split_bytes(d):
    c = d.connect()
    for byte in b"#split ping echo=slowly\r\n":
        c.raw(bytes([byte]))
        time.sleep(0.001)
    head, _ = c.reply()
    equal((head["tag"], head["echo"]), ("split", "slowly"), "the reply")
    c.close()


def pipelining(d):
    c = d.connect()
    count = 500
    c.raw(b"".join(b"#%d ping\n" % i for i in range(count)))
    for i in range(count):
        equal(c.reply()[0]["tag"], str(i), "order")
    # Captures amid other requests keep their place, bytes and all.
    c.raw(b"#a ping\n#b capture format=jpeg\n#c get fibre.eta\n"
          b"#d capture format=jpeg\n#e quit\n")
    got = [c.reply() for _ in range(5)]
    equal([h["tag"] for h, _ in got], list("abcde"), "order")
    true(got[1][1] == got[3][1] and got[1][1][:2] == b"\xff\xd8", "captures")
    true(c.ended(), "closed")
    c.close()


def replies_that_pile_up(d):
    """Far more replies than are buffered: reading goes on as they are taken."""
    c = d.connect()
    count = 400  # of about 10 KB each
    c.socket.settimeout(30)
    import threading
    sender = threading.Thread(
        target=lambda: c.raw(b"".join(b"#%d schema\n" % i
                                      for i in range(count))))
    sender.start()
    time.sleep(0.2)
    for i in range(count):
        head, _ = c.reply()
        equal(head["tag"], str(i), "order")
    sender.join()
    c.ask("ping")
    c.close()


def line_limit(d):
    c = d.connect()
    most = 'ping echo="' + "x" * (65536 - len('ping echo=""')) + '"'
    equal(len(most), 65536, "the longest line")
    equal(len(c.ask(most)["echo"]), 65524, "it is read")
    c.send(most[:-1] + 'x"')
    head, _ = c.reply()
    equal(head["error"]["code"], "limit", "one byte more")
    true(c.ended(), "closed")
    c.close()
    # Told without waiting for the line's end.
    c = d.connect()
    c.raw(b"x" * 70000)
    equal(c.reply()[0]["error"]["code"], "limit", "no end in sight")
    true(c.ended(), "closed")
    c.close()


def http_never_runs_as_commands(d):
    c = d.connect()
    c.ask("ping")
    before = d_value(d)
    c.raw(b"POST / HTTP/1.1\r\nset fibre.eta=2\r\n")
    equal(c.reply()[0]["error"]["code"], "http", "code")
    true(c.ended(), "closed")
    equal(d_value(d), before, "nothing was set")
    c.close()
    # A browser's post from the first byte on: answered as HTTP and closed.
    with socket.create_connection(d.address, 10) as s:
        s.sendall(b"POST / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n"
                  b"Content-Length: 16\r\n\r\nset fibre.eta=2\n" % d.port)
        data = b""
        while True:
            more = s.recv(4096)
            if not more:
                break
            data += more
    true(data.startswith(b"HTTP/1.1 405") or data.startswith(b"HTTP/1.1 413"),
         data[:40])
    equal(d_value(d), before, "nothing was set")


def d_value(d):
    c = d.connect()
    value = c.ask("get fibre.eta")["values"]["fibre.eta"]
    c.close()
    return value


def half_closed_clients_are_answered(d):
    """printf ... | nc: requests, then the end of sending."""
    c = d.connect()
    c.raw(b"#1 ping\n#2 capture format=png\n#3 ping\nhalf a li")
    c.socket.shutdown(socket.SHUT_WR)
    tags = [c.reply()[0]["tag"] for _ in range(3)]
    equal(tags, ["1", "2", "3"], "all were answered")
    true(c.ended(), "closed")
    c.close()


def unix_socket(d):
    from glint_wire import Line
    import os
    import stat
    mode = os.stat(d.unix).st_mode
    true(stat.S_ISSOCK(mode) and stat.S_IMODE(mode) & 0o077 == 0,
         "for its owner only")
    c = Line(d.unix)
    equal(c.ask("#u hello")["tag"], "u", "tag")
    f, body = c.capture("format=jpeg")
    equal(len(body), f["bytes"], "a capture")
    c.close()


def numbers_are_exact(d):
    """What is set is what is got: the nearest float, in its shortest form."""
    c = d.connect()
    for text, want in (("1.6", "1.6"), ("1.05", "1.05"), ("1.1000000238", "1.1"),
                       ("0.2e1", "2"), ("1.23456789", "1.2345679")):
        c.ask("set fibre.eta=" + text)
        c.send("get fibre.eta")
        line = c.file.readline().decode()
        true('"fibre.eta":%s}' % want in line, line)
        json.loads(line)
    c.close()


if __name__ == "__main__":
    run([malformed_lines_do_not_close, errors_carry_the_tag, split_bytes,
         pipelining, replies_that_pile_up, line_limit,
         http_never_runs_as_commands, half_closed_clients_are_answered,
         unix_socket, numbers_are_exact], Daemon())
