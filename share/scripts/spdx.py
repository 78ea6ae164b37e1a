#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Puts the SPDX line first into every source file that lacks it: spdx.py [--check]"""
import subprocess
import sys

LINE = "SPDX-License-Identifier: BSD-3-Clause"
MARKS = {".h": "//", ".cpp": "//", ".inc": "//", ".py": "#", ".sh": "#", ".cmake": "#"}

missing = []
for name in subprocess.run(["git", "ls-files"], capture_output=True, text=True,
                           check=True).stdout.split("\n"):
    suffix = "." + name.rpartition(".")[2]
    if suffix not in MARKS and not name.endswith("CMakeLists.txt"):
        continue
    text = open(name, encoding="utf-8").read()
    if LINE in text[:300]:
        continue
    missing.append(name)
    if "--check" in sys.argv[1:]:
        continue
    mark = MARKS.get(suffix, "#")
    head = ""
    if text.startswith("#!"):
        head, _, text = text.partition("\n")
        head += "\n"
    with open(name, "w", encoding="utf-8") as out:
        out.write(f"{head}{mark} {LINE}\n{text}")
print(f"{len(missing)} files without the line" +
      ("" if "--check" in sys.argv[1:] else "; added"))
for name in missing if "--check" in sys.argv[1:] else []:
    print(name)
sys.exit(1 if missing and "--check" in sys.argv[1:] else 0)
