#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Lists the tests that were skipped, each with the reason: skipped_tests.py LastTest.log

The log is what ctest leaves in Testing/Temporary. Reads what GoogleTest prints of
GTEST_SKIP() and Python's unittest of skipTest().
"""

import re
import sys

START = re.compile(r"^\d+/\d+ (?:Testing|Test): (\S+)$")
GTEST = re.compile(r"^\S+:\d+: Skipped$")
UNITTEST_TITLE = re.compile(r"^(test_\S+) \(")
UNITTEST_LATE = re.compile(r"skipped ['\"](.*)['\"]$")


def skipped(lines):
    """Yields (test, reason)."""
    test = part = None
    gtest_reason = False
    for line in (each.rstrip("\n") for each in lines):
        if start := START.match(line):
            test, part, gtest_reason = start[1], None, False
        elif gtest_reason:
            if line:
                yield test, line
                gtest_reason = False
        elif GTEST.match(line):
            gtest_reason = True
        else:
            if title := UNITTEST_TITLE.match(line):
                part = title[1]
            if late := UNITTEST_LATE.search(line):
                yield f"{test}.{part}" if part else test, late[1]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8", errors="replace") as log:
        found = sorted(set(skipped(log)))
    print(f"Skipped tests: {len(found)}")
    for test, reason in found:
        print(f"  {test}: {reason}")


if __name__ == "__main__":
    main()
