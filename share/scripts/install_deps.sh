#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the Debian packages that building, testing and the demo need, and
# only those that are missing. Does nothing, and needs no network and no rights,
# when all are there: install_deps.sh [--packaging | --checks]
#   --packaging  also what building packages needs
#   --checks     also what share/scripts/check.sh needs
set -euo pipefail

packages=(
    g++ cmake ninja-build
    libeigen3-dev libmrpt-dev liboctomap-dev libcli11-dev nlohmann-json3-dev
    zlib1g-dev libzstd-dev # recordings are compressed
    libpng-dev            # pictures of maps, depth images
    libbz2-dev liblz4-dev libsqlite3-dev # bags of ROS 1 and 2
    libtbb-dev            # what GCC's parallel algorithms run in
    libgtest-dev libbenchmark-dev
    gnuplot-nox           # plots of superray-bench paper
    mrpt-apps mrpt-common # the stock programs and the recorded scans
    python3               # system tests
    xvfb xauth xdotool imagemagick libgl1-mesa-dri # system tests with windows
)
[[ ${1:-} != --checks ]] || packages+=(clang-format clang-tidy doxygen git)
[[ ${1:-} != --packaging ]] || packages+=(help2man file dpkg-dev)

missing=()
for package in "${packages[@]}"; do
    status=$(dpkg-query --show --showformat='${db:Status-Abbrev}' "$package" 2>/dev/null || true)
    [[ $status == ii* ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
        echo "error: these packages are missing, and installing them needs root or sudo:" >&2
        echo "  apt-get install ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo)
fi

echo "Installing: ${missing[*]}"
apt() {
    ${as_root[@]+"${as_root[@]}"} env DEBIAN_FRONTEND=noninteractive apt-get -qq \
        -o Dpkg::Use-Pty=0 "$@" </dev/null
}
apt update
apt install --yes --no-install-recommends "${missing[@]}" >/dev/null
