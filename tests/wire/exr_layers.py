"""Reads EXR files of 32-bit floats, scan lines, ZIP: what `depth=float` makes."""
import struct
import zlib


def header(data):
    """Attributes by name, and where the chunks' table begins."""
    if data[:8] != struct.pack("<II", 20000630, 2):
        raise AssertionError("not a single-part scan-line EXR")
    at, out = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)[0:2] + [None]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<I", data, at)[0]
        out[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    return out, at + 1


def channel_names(chlist):
    names, at = [], 0
    while chlist[at]:
        end = chlist.index(b"\0", at)
        if struct.unpack_from("<i", chlist, end + 1)[0] != 2:
            raise AssertionError("a channel that is not float")
        names.append(chlist[at:end].decode())
        at = end + 17
    return names


def unpack(packed, size):
    """ZIP of OpenEXR: differences of bytes, halves interleaved."""
    if len(packed) == size:
        return packed
    raw = bytearray(zlib.decompress(packed))
    for i in range(1, len(raw)):
        raw[i] = (raw[i - 1] + raw[i] - 128) & 255
    out, half = bytearray(size), (size + 1) // 2
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return bytes(out)


def read(data):
    """(width, height, {channel: [float, ...]}, attributes)"""
    about, at = header(data)
    x0, y0, x1, y1 = struct.unpack("<4i", about["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names = channel_names(about["channels"])
    planes = {n: [] for n in names}
    for chunk in range((height + 15) // 16):
        start = struct.unpack_from("<Q", data, at + 8 * chunk)[0]
        y, size = struct.unpack_from("<iI", data, start)
        rows = min(16, height - y)
        plain = unpack(data[start + 8:start + 8 + size],
                       4 * width * rows * len(names))
        values = struct.unpack("<%df" % (len(plain) // 4), plain)
        for row in range(rows):
            for i, n in enumerate(names):
                first = (row * len(names) + i) * width
                planes[n] += values[first:first + width]
    return width, height, planes, about
