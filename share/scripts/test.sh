#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds everything and runs all tests: test.sh [PRESET [CTEST OPTION...]]
#   PRESET        a preset of CMakePresets.json; default: release
#   CTEST OPTION  which tests, e.g. test.sh release -L maps (areas are labels)
# With CI=true in the environment, warnings are errors.
set -euo pipefail
preset=${1:-release}
shift || true
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash share/scripts/install_deps.sh
options=(-DSUPERRAY_BUILD_TESTS=ON)
! command -v ccache >/dev/null || options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
[[ ${CI:-} != true ]] || options+=(-DSUPERRAY_WERROR=ON)
cmake --preset "$preset" "${options[@]}"
cmake --build --preset "$preset" --parallel "$(nproc)"
status=0
ctest --test-dir "build/$preset" --output-on-failure --parallel "$(nproc)" \
    "$@" || status=$?
python3 share/scripts/skipped_tests.py "build/$preset/Testing/Temporary/LastTest.log"
exit "$status"
