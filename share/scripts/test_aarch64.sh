#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds core and storage for aarch64 in a fresh Debian root, and runs their exactness
# tests there by qemu: the digests of tests/storage/digest_table_test.cpp hold for every
# processor. Prints that table at the end.
#
#   test_aarch64.sh [RELEASE]      default: trixie
#
# Needs root, debootstrap and a network. Exit code: 0 passed, 1 failed.
set -euo pipefail
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
release=${1:-trixie}
root=$(mktemp -d "${TMPDIR:-/var/tmp}/superray-aarch64-XXXXXX")
trap 'rm -rf --one-file-system "$root" "$root.log"' EXIT

debootstrap --variant=minbase "$release" "$root" >"$root.log" 2>&1 ||
    { tail -n 5 "$root.log" >&2; exit 1; }
cp -L /etc/resolv.conf /etc/hosts "$root/etc/" 2>/dev/null || true
# Package lists of a mirror that stands still are past their date.
echo 'Acquire::Check-Valid-Until "false";' >"$root/etc/apt/apt.conf.d/90mirror"
mkdir "$root/superray"
cp -r "$source_dir"/{libs,share,tests} "$root/superray"
# A mount namespace of its own: nothing is left behind.
unshare --mount bash -euo pipefail -s "$root" <<'EOF'
mount -t proc proc "$1/proc"
mount --rbind /dev "$1/dev"
chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive bash -euo pipefail <<'INSIDE'
dpkg --add-architecture arm64
apt-get -qq update
apt-get -qq install --yes --no-install-recommends crossbuild-essential-arm64 cmake \
    ninja-build qemu-user-static libeigen3-dev libgtest-dev:arm64 liboctomap-dev:arm64 \
    libtbb-dev:arm64 zlib1g-dev:arm64 </dev/null >/dev/null 2>&1
emulator=$(command -v qemu-aarch64-static || command -v qemu-aarch64)
cmake -G Ninja -S /superray/tests/exactness -B /build -DSUPERRAY_WERROR=ON \
    -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DCMAKE_LIBRARY_ARCHITECTURE=aarch64-linux-gnu \
    -DCMAKE_CROSSCOMPILING_EMULATOR="$emulator"
cmake --build /build
ctest --test-dir /build --output-on-failure
"$emulator" /build/digest_table_test | grep '^digest'
INSIDE
EOF
