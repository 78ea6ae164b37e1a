#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds core and storage for aarch64 in a fresh Debian root, and runs their exactness
# tests there by qemu: the digests of tests/storage/digest_table_test.cpp hold for every
# processor.
#
#   test_aarch64.sh [RELEASE]      default: trixie
#
# Needs root, debootstrap and a network. Exit code: 0 passed, 1 failed.
set -euo pipefail
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
release=${1:-trixie}
root=$(mktemp -d "${TMPDIR:-/tmp}/superray-aarch64.XXXXXX")
trap 'rm -rf --one-file-system "$root"' EXIT

debootstrap --variant=minbase "$release" "$root"
mkdir "$root/superray"
cp -r "$source_dir"/{libs,share,tests} "$root/superray"
# A mount namespace of its own: nothing is left behind.
unshare --mount bash -euo pipefail -s "$root" <<'EOF'
mount -t proc proc "$1/proc"
mount --rbind /dev "$1/dev"
chroot "$1" bash -euo pipefail <<'INSIDE'
export DEBIAN_FRONTEND=noninteractive
dpkg --add-architecture arm64
apt-get -qq update
apt-get -qq install --yes --no-install-recommends crossbuild-essential-arm64 cmake \
    ninja-build qemu-user-static libeigen3-dev libgtest-dev:arm64 liboctomap-dev:arm64 \
    libtbb-dev:arm64 zlib1g-dev:arm64 </dev/null
cmake -G Ninja -S /superray/tests/exactness -B /build -DSUPERRAY_WERROR=ON \
    -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DCMAKE_LIBRARY_ARCHITECTURE=aarch64-linux-gnu \
    -DCMAKE_CROSSCOMPILING_EMULATOR="$(command -v qemu-aarch64-static || command -v qemu-aarch64)"
cmake --build /build
ctest --test-dir /build --output-on-failure
/build/digest_table_test | grep ^digest 2>/dev/null ||
    "$(command -v qemu-aarch64-static || command -v qemu-aarch64)" /build/digest_table_test | grep ^digest
INSIDE
EOF
