#!/usr/bin/env python3
"""Python's zlib reads what the encoders write, and writes no more tightly
when it takes less trouble."""
import os
import random
import struct
import subprocess
import sys
import zlib

GLINTD = os.environ.get("GLINTD", "build/glintd")
TOOL = os.path.join(os.path.dirname(GLINTD), "tests/unit/test_encode_png")


def tool(args, data=b""):
    return subprocess.run([TOOL] + args, input=data, stdout=subprocess.PIPE,
                          check=True, timeout=60).stdout


def inputs():
    draw = random.Random(12)
    yield from (b"", b"a", b"abc", b"aaaa", b"\0" * 258, b"\xff" * 32769)
    yield bytes(range(256)) * 130
    yield draw.randbytes(100000)
    yield bytes(min(255, int(draw.expovariate(0.3))) for _ in range(200000))
    yield " ".join(str(draw.randrange(500)) for _ in range(60000)).encode()
    yield draw.randbytes(32760) * 3 + draw.randbytes(40000) * 2


def streams():
    for data in inputs():
        if zlib.decompress(tool(["--deflate"], data)) != data:
            return "%d bytes came back changed" % len(data)


def rows(png):
    """The inflated IDAT."""
    at, idat = 8, b""
    while at < len(png):
        n, kind = struct.unpack(">I4s", png[at:at + 8])
        crc, = struct.unpack(">I", png[at + 8 + n:at + 12 + n])
        if zlib.crc32(png[at + 4:at + 8 + n]) != crc:
            raise ValueError("CRC of " + kind.decode())
        if kind == b"IDAT":
            idat += png[at + 8:at + 8 + n]
        at += 12 + n
    return idat, zlib.decompress(idat)


def sizes():
    for kind, step in (("rgba", 4), ("rgb", 3)):
        idat, raw = rows(tool(["--hair", kind]))
        if len(raw) != 480 * (1 + 720 * step):
            return "%d bytes of %s rows" % (len(raw), kind)
        fast, usual = (len(zlib.compress(raw, level)) for level in (1, 6))
        # between zlib's levels 1 and 6, as promised to whoever waits for it
        if len(idat) > fast:
            return "%s: %d bytes; zlib at level 1: %d, at 6: %d" % (
                kind, len(idat), fast, usual)


def main():
    failed = False
    for name, case in (("zlib reads our streams", streams),
                       ("PNG is smaller than with zlib's level 1", sizes)):
        name = "encode: " + name
        if not os.path.exists(TOOL):
            print("skip %s: %s is not built" % (name, TOOL))
            continue
        why = case()
        print("%s %s" % ("not ok" if why else "ok", name))
        if why:
            print("  " + why)
            failed = True
    sys.exit(failed)


main()
