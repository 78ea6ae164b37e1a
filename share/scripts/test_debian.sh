#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Does what a new user does, in a fresh root of a Debian release:
#
#   test_debian.sh RELEASE [--user] [--packages] [--tests OPTIONS]... [--keep DIR]
#                  [--ccache DIR]
#
#   RELEASE     bookworm, trixie, sid, ...
#   --user      as a plain user with sudo instead of root
#   --packages  afterwards build the packages, and test them in another fresh root
#   --tests OPTIONS  what test.sh is called with, e.g. "release --areas maps,system"; once
#               for each --tests. Default: all tests of the preset release
#   --keep DIR  where the root is made; DIR must not exist, and stays. Default: a
#               folder that is removed at the end
#   --ccache DIR  saves time when it is done again: ccache is installed there, and
#               keeps what it compiled in DIR (with --user it only reads from DIR)
#
# Runs demo.sh and test.sh there on the committed state of this checkout, with
# ../shared beside it (read-only) if it exists. Needs root, debootstrap (installed
# where missing) and a network. Mounts are private to this script: none is left behind.
# With CI=true in the environment, warnings are errors there, too.
#
# Exit code: 0 passed, 1 failed, 2 usage, 77 no such root can be made here.
set -euo pipefail
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

usage() { sed -n '3,24s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
cannot() { echo "CANNOT TEST in a fresh root: $1" >&2; exit 77; }

release= keep= cache= as_user=0 packages=0 tests=()
while [[ $# -gt 0 ]]; do
    case $1 in
        --user) as_user=1; shift ;;
        --packages) packages=1; shift ;;
        --tests) [[ $# -gt 1 ]] || usage; tests+=("$2"); shift 2 ;;
        --keep) [[ $# -gt 1 ]] || usage; keep=$2; shift 2 ;;
        --ccache) [[ $# -gt 1 ]] || usage; cache=$2; shift 2 ;;
        -*) usage ;;
        *) [[ -z $release ]] || usage; release=$1; shift ;;
    esac
done
[[ -n $release ]] || usage

[[ $(id -u) -eq 0 ]] || cannot "this needs root"
if ! command -v debootstrap >/dev/null; then
    { apt-get -qq update && apt-get -qq install --yes debootstrap; } </dev/null >/dev/null 2>&1 ||
        cannot "debootstrap is missing and cannot be installed"
fi
unshare --mount true 2>/dev/null || cannot "private mounts are not allowed"

if [[ -n $keep ]]; then
    [[ ! -e $keep ]] || { echo "error: $keep exists" >&2; exit 2; }
    mkdir -p "$keep"
    root=$(cd "$keep" && pwd)
else
    root=$(mktemp -d "${TMPDIR:-/var/tmp}/superray-$release-XXXXXX")
    trap 'rm -rf --one-file-system "$root"' EXIT
fi

if [[ -n $cache ]]; then
    mkdir -p "$cache"
    cache=$(cd "$cache" && pwd)
fi

passed=  # not empty when something was tested already

# make_root DIR: a minimal system of the release, which reaches what this one reaches.
make_root() {
    debootstrap --variant=minbase "$release" "$1" >"$1.log" 2>&1 || {
        tail -n 5 "$1.log" >&2
        rm -f "$1.log"
        [[ -z $passed ]] || { echo "error: debootstrap $release failed" >&2; exit 1; }
        cannot "debootstrap $release failed"
    }
    rm -f "$1.log"
    cp -L /etc/resolv.conf /etc/hosts "$1/etc/" 2>/dev/null || true
    # Package lists of a mirror that stands still are past their date.
    printf '%s\n' 'Acquire::Check-Valid-Until "false";' 'Acquire::Retries "3";' \
        >"$1/etc/apt/apt.conf.d/90mirror"
    # Nobody needs this root after a power cut: without syncs, packages install much faster.
    mkdir -p "$1/etc/dpkg/dpkg.cfg.d"
    echo force-unsafe-io >"$1/etc/dpkg/dpkg.cfg.d/90fast"
}

# in_root DIR COMMAND: runs a shell command there, in the checkout's copy.
in_root() {
    unshare --mount --propagation private --pid --fork --kill-child bash -euc '
        root=$1 shared=$2 cache=$4 ci=$5
        mount -t proc proc "$root/proc"
        mount --rbind /sys "$root/sys"
        mount --rbind /dev "$root/dev"
        if [[ -d $shared ]]; then
            mkdir -p "$root/srv/shared"
            mount --bind "$shared" "$root/srv/shared"
            mount -o remount,bind,ro "$root/srv/shared"
        fi
        settings=(CI="$ci")
        if [[ -n $cache ]]; then
            mkdir -p "$root/srv/ccache"
            mount --bind "$cache" "$root/srv/ccache"
            settings+=(CCACHE_DIR=/srv/ccache CCACHE_BASEDIR=/srv CCACHE_NOHASHDIR=1)
        fi
        exec chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
            LANG=C.UTF-8 "${settings[@]}" bash -euc "cd /srv/superray; $3"' \
        - "$1" "$source_dir/../shared" "$2" "$cache" "${CI:-}" </dev/null
}

# copy_checkout DIR
copy_checkout() {
    mkdir -p "$1/srv/superray"
    if git -C "$source_dir" rev-parse --verify -q HEAD >/dev/null 2>&1; then
        git -C "$source_dir" diff --quiet HEAD ||
            echo "note: changes that are not committed are not tested" >&2
        git -C "$source_dir" archive HEAD | tar -x -C "$1/srv/superray"
    else
        tar -c -C "$source_dir" --exclude ./build --exclude ./out . |
            tar -x -C "$1/srv/superray"
    fi
}

echo "=== A fresh root of Debian $release: $root"
make_root "$root/system"
copy_checkout "$root/system"
in_root "$root/system" "apt-get -qq update" || cannot "package lists of $release are out of reach"

if [[ -n $cache ]]; then
    in_root "$root/system" \
        "apt-get -qq install --yes --no-install-recommends ccache >/dev/null 2>&1"
fi

[[ ${#tests[@]} -gt 0 ]] || tests=(release)
commands="bash share/scripts/demo.sh"
for options in "${tests[@]}"; do commands+="; bash share/scripts/test.sh $options"; done
echo "=== Debian $release: $commands"
if ((as_user)); then
    in_root "$root/system" "
        apt-get -qq install --yes --no-install-recommends sudo >/dev/null
        useradd --create-home --shell /bin/bash tester
        echo 'tester ALL=(ALL) NOPASSWD: ALL' >/etc/sudoers.d/tester
        chown -R tester: /srv/superray
        export CCACHE_READONLY=1 CCACHE_TEMPDIR=/tmp/ccache
        su tester -c 'set -eu; $commands'"
else
    in_root "$root/system" "$commands"
fi

passed=yes
if ((packages)); then
    echo "=== Debian $release: packages"
    in_root "$root/system" "bash share/scripts/package.sh out/packages"
    make_root "$root/clean"
    mkdir -p "$root/clean/srv/superray"
    cp -r "$root/system/srv/superray/out/packages" "$root/clean/srv/"
    copy_checkout "$root/clean"
    in_root "$root/clean" "bash tests/system/packages_test.sh /srv/packages"
fi
echo "=== Debian $release: passed"
