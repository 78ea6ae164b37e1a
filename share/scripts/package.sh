#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds the Debian packages of this release: package.sh [OUTDIR]   (default: ./packages)
# Installs what building needs.
set -euo pipefail
out=${1:-packages}
mkdir -p "$out"
out=$(cd "$out" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

bash share/scripts/install_deps.sh --packaging
options=()
! command -v ccache >/dev/null || options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
[[ ${CI:-} != true ]] || options+=(-DSUPERRAY_WERROR=ON) # as test.sh
cmake --preset release -B build/package -DCMAKE_INSTALL_PREFIX=/usr \
    -DCMAKE_SKIP_INSTALL_RPATH=ON -DSUPERRAY_BUILD_TESTS=OFF -DSUPERRAY_BUILD_MAN=ON \
    ${options[@]+"${options[@]}"}
cmake --build build/package --parallel "$(nproc)"
rm -f build/package/*.deb
(cd build/package && cpack)
cp build/package/*.deb "$out"
ls -l "$out"
