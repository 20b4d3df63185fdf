#!/usr/bin/env python3
"""The page in a real browser: prepares node's side and runs drive.mjs.

Prints ok / not ok / skip lines, which drive.mjs makes.  Skips, with the
reason, where node, npm, Chromium or the package cannot be had.
"""
import json
import os
import shutil
import signal
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
# s; about 20 are used, under sanitizers on a machine five times overbooked 150
LIMIT = 280 if os.environ.get("GLINT_SAN") else 150


def skip(reason):
    print("skip browser: " + reason)
    sys.exit(77)


def installed():
    with open(os.path.join(HERE, "package.json")) as f:
        want = json.load(f)["dependencies"]["playwright-core"]
    try:
        with open(os.path.join(HERE, "node_modules", "playwright-core",
                               "package.json")) as f:
            return json.load(f)["version"] == want
    except (OSError, ValueError):
        return False


def install():
    if installed():
        return
    try:
        got = subprocess.run(
            ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"],
            cwd=HERE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL, timeout=60)
    except subprocess.TimeoutExpired:
        skip("npm ci took longer than 60 s")
    if got.returncode:
        last = got.stdout.decode("utf-8", "replace").strip().splitlines()
        skip("npm ci failed: " + (last[-1] if last else "without a word"))


def main():
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    for name, found in (("node", shutil.which("node")),
                        ("npm", shutil.which("npm")),
                        ("chromium", chromium)):
        if not found:
            skip(name + " is not installed")
    install()
    root = os.path.dirname(os.path.dirname(HERE))
    env = dict(os.environ, CHROMIUM=chromium, ROOT=root)
    env.setdefault("GLINTD", os.path.join(root, "build", "glintd"))
    # Its own process group: whatever it started ends with it.
    run = subprocess.Popen(["node", os.path.join(HERE, "drive.mjs")], env=env,
                           stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        code = run.wait(LIMIT)
    except subprocess.TimeoutExpired:
        print("not ok browser: longer than %d s" % LIMIT)
        code = 1
    finally:
        try:
            os.killpg(run.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    sys.exit(code)


if __name__ == "__main__":
    main()
