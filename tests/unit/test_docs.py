#!/usr/bin/env python3
"""The parameter page of the docs is what the table says; links lead somewhere."""
import glob
import os
import re
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GLINT = os.environ.get("GLINT", os.path.join(ROOT, "build", "glint"))

made = subprocess.run([GLINT, "get", "--markdown"], capture_output=True,
                      text=True, timeout=30).stdout
kept = open(os.path.join(ROOT, "docs", "PARAMETERS.md")).read()
if made and kept.endswith(made):
    print("ok docs/PARAMETERS.md is the parameter table")
else:
    print("  run `make docs`")
    print("not ok docs/PARAMETERS.md is the parameter table")

bad = []
pages = glob.glob(os.path.join(ROOT, "*.md")) + glob.glob(
    os.path.join(ROOT, "docs", "*.md")) + glob.glob(os.path.join(ROOT, "protocol", "*.md"))
for page in pages:
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", open(page).read()):
        if "://" in target:
            continue
        if not os.path.exists(os.path.join(os.path.dirname(page), target)):
            bad.append("%s -> %s" % (os.path.relpath(page, ROOT), target))
print("\n".join("  " + b for b in bad))
print("%s links in the docs lead somewhere" % ("not ok" if bad else "ok"))
