#!/usr/bin/env python3
"""The two programs link what they may, and nothing else."""
import os
import re
import subprocess

PLAIN = os.environ.get("GLINT_PLAIN", "build")  # a build without sanitizers
ALLOWED = {
    "glintd": {"libEGL.so.1", "libc.so.6", "libm.so.6", "libpthread.so.0",
               "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"},
    "glint": {"libc.so.6", "libm.so.6"},
}
OPENEXR = re.compile(r"libOpenEXR(Core)?(-\d+_\d+)?\.so\.\d+$")

for name, allowed in ALLOWED.items():
    out = subprocess.run(["readelf", "-d", os.path.join(PLAIN, name)],
                         capture_output=True, text=True, timeout=30)
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", out.stdout)
    if name == "glintd":
        needed = [n for n in needed if not OPENEXR.match(n)]
    bad = sorted(set(needed) - allowed)
    if out.returncode != 0 or not needed:
        print("  readelf: " + out.stderr.strip())
        print("not ok %s links only what it may" % name)
    elif bad:
        print("  %s needs %s" % (name, ", ".join(bad)))
        print("not ok %s links only what it may" % name)
    else:
        print("ok %s links only what it may" % name)
