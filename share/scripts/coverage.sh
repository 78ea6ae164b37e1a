#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Which lines of libs/ the tests run: coverage.sh [CTEST OPTION...]
# Builds the preset `coverage`, runs the tests, prints a line for each file, and leaves
# pages that show the lines in build/coverage/pages. Fails below 90 % of the lines, and
# where a test fails.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=build/coverage
lowest=90 # [%]

if ! command -v gcovr >/dev/null; then
    echo "error: gcovr is missing; it is Debian's package gcovr" >&2
    exit 1
fi
find "$build" -name '*.gcda' -delete 2>/dev/null || true # counts of earlier runs
status=0
bash share/scripts/test.sh coverage "$@" || status=$?
rm -rf "$build/pages"
mkdir "$build/pages"
# What is compiled for other processors only cannot run here.
gcovr --root . --filter 'libs/' --exclude-throw-branches -j "$(nproc)" \
    --gcov-ignore-parse-errors --html-details "$build/pages/index.html" \
    --txt "$build/coverage.txt" --fail-under-line "$lowest" "$build" || status=$?
cat "$build/coverage.txt"
exit "$status"
