#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds everything and runs all tests: test.sh [PRESET] [--areas A,B] [CTEST OPTION...]
#   PRESET       a preset of CMakePresets.json; default: release
#   --areas A,B  builds and runs only the tests of these areas: core, storage, maps, eval,
#                slam, system, fuzz
#   CTEST OPTION which tests, e.g. test.sh release -R likelihood
# With CI=true in the environment, warnings are errors.
set -euo pipefail
preset=release
if [[ $# -gt 0 && $1 != -* ]]; then
    preset=$1
    shift
fi
targets=()
if [[ ${1:-} == --areas && $# -gt 1 ]]; then
    for area in ${2//,/ }; do targets+=(--target "tests_$area"); done
    labels="^(${2//,/|})\$"
    shift 2
    set -- -L "$labels" "$@"
fi
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash share/scripts/install_deps.sh
options=(-DSUPERRAY_BUILD_TESTS=ON)
! command -v ccache >/dev/null || options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
[[ ${CI:-} != true ]] || options+=(-DSUPERRAY_WERROR=ON)
cmake --preset "$preset" "${options[@]}"
cmake --build --preset "$preset" --parallel "$(nproc)" ${targets[@]+"${targets[@]}"}
status=0
ctest --preset "$preset" --no-tests=error --parallel "$(nproc)" "$@" || status=$?
python3 share/scripts/skipped_tests.py "build/$preset/Testing/Temporary/LastTest.log"
exit "$status"
