#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A project that links superray::core and superray::storage alone configures, builds and
# runs where MRPT and Google Benchmark are not found: consumer_core.sh [WORK_FOLDER]
set -euo pipefail
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
if [[ $# -gt 0 ]]; then
    work=$1
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
fi
absent=()
for package in mrpt-maps mrpt-slam mrpt-gui mrpt-obs benchmark CLI11 nlohmann_json GTest; do
    absent+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

cmake -S "$source_dir" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DSUPERRAY_BUILD_MAPS=OFF "${absent[@]}" ${launcher[@]+"${launcher[@]}"}
cmake --build "$work/build"
cmake --install "$work/build" --prefix "$work/prefix"
cmake -S "$source_dir/tests/system/consumer" -B "$work/consumer" -G Ninja \
    -DCMAKE_BUILD_TYPE=Release "-DCMAKE_PREFIX_PATH=$work/prefix" "${absent[@]}"
cmake --build "$work/consumer"
[[ $("$work/consumer/core_only") == "4 cells" ]]
[[ $("$work/consumer/storage_only") == "equal" ]]
echo "core and storage alone: built and used"
