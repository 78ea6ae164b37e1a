#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds everything and runs all tests: test.sh [PRESET]
#   PRESET  a preset of CMakePresets.json; default: release
set -euo pipefail
preset=${1:-release}
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash share/scripts/install_deps.sh
launcher=()
command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
cmake --preset "$preset" -DSUPERRAY_BUILD_TESTS=ON ${launcher[@]+"${launcher[@]}"}
cmake --build --preset "$preset" --parallel "$(nproc)"
status=0
ctest --test-dir "build/$preset" --output-on-failure --parallel "$(nproc)" || status=$?
python3 share/scripts/skipped_tests.py "build/$preset/Testing/Temporary/LastTest.log"
exit "$status"
