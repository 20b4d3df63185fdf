#!/usr/bin/env python3
"""Runs test programs and counts their cases.

Usage: run.py [--timeout SECONDS] PROGRAM...
A program is an executable or a .py file.  It prints "ok NAME", "not ok NAME"
or "skip NAME: reason" lines; other lines are shown only when it fails.  A
program that crashes, runs too long or prints no case counts as one failure.
Exit status 77 without any case line counts as one skip.  The last line printed
is "N passed, N failed, N skipped"; the exit status is 1 if anything failed.
"""
import os
import subprocess
import sys
import time


def run_one(path, timeout):
    args = [sys.executable, path] if path.endswith(".py") else [path]
    began = time.monotonic()
    try:
        done = subprocess.run(args, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=timeout,
                              stdin=subprocess.DEVNULL)
        out, code = done.stdout, done.returncode
    except subprocess.TimeoutExpired as late:
        out, code = late.stdout or b"", "timeout after %d s" % timeout
    text = out.decode("utf-8", "replace")
    lines = text.splitlines()
    passed = sum(x.startswith("ok ") for x in lines)
    failed = sum(x.startswith("not ok ") for x in lines)
    skips = [x for x in lines if x.startswith("skip ")]
    skipped = len(skips)
    if code == 77 and passed + failed + skipped == 0:
        skipped, skips = 1, ["skip " + path + ": " + text.strip()]
    elif code not in (0, 77) and failed == 0:
        failed = 1
    elif passed + failed + skipped == 0:
        failed, code = 1, "no case was run"
    seconds = time.monotonic() - began
    verdict = "FAIL" if failed else "skip" if not passed else "ok"
    print("%-4s %-48s %4d passed %3d failed %3d skipped %7.1f s" %
          (verdict, os.path.relpath(path), passed, failed, skipped, seconds))
    for line in skips:
        print("     " + line)
    if failed:
        print("     exit: %s\n%s" % (code, "\n".join("     | " + x
                                                     for x in lines[-200:])))
    sys.stdout.flush()
    return passed, failed, skipped


def main(argv):
    timeout = 300
    if argv and argv[0] == "--timeout":
        timeout, argv = int(argv[1]), argv[2:]
    total = [0, 0, 0]
    for path in argv:
        total = [a + b for a, b in zip(total, run_one(path, timeout))]
    print("%d passed, %d failed, %d skipped" % tuple(total))
    return 1 if total[1] or not any(total) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
