#!/usr/bin/env python3
"""Puts the short table of docs/EDITS.md into the README, between the same marks.
`--check` only says whether it is there as it stands."""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MARKS = re.compile(r"<!-- short -->\n(.*?)<!-- end -->", re.S)


def main():
    page = open(os.path.join(ROOT, "docs", "EDITS.md")).read()
    path = os.path.join(ROOT, "README.md")
    readme = open(path).read()
    short, shown = MARKS.search(page), MARKS.search(readme)
    if not short or not shown:
        print("docs/EDITS.md or README.md has no marks", file=sys.stderr)
        return 1
    if "--check" in sys.argv:
        return short.group(0) != shown.group(0)
    with open(path, "w") as out:
        out.write(readme[:shown.start()] + short.group(0) + readme[shown.end():])
    return 0


if __name__ == "__main__":
    sys.exit(main())
