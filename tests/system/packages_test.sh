#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the packages in a system that has nothing of superray, and uses them as a
# user does: packages_test.sh DIR     (changes the system: for a fresh root)
set -euo pipefail
packages=$(cd "${1:?packages_test.sh DIR}" && pwd)
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[[ ! -e /usr/bin/superray-map ]] || { echo "error: superray is installed already" >&2; exit 2; }
work=$(mktemp -d)
cd "$work"
export DEBIAN_FRONTEND=noninteractive
datasets=/usr/share/mrpt/datasets
laser=$datasets/"2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"

step() { echo "--- $*"; }

step "superray alone, with what it needs"
apt-get -qq update
apt-get -qq install --yes --no-install-recommends "$packages"/superray_*.deb mrpt-apps \
    mrpt-common man-db >/dev/null
superray-map --version
superray-map build "$datasets/tests_rgbd.rawlog" -o room.srmap --fixed-robot --resolution 0.05
superray-map info room.srmap
for program in superray-map superray-bench superray-slam; do
    man "$program" | grep -q -i "$program" || { echo "error: no man page of $program" >&2; exit 1; }
done

step "stock icp-slam with the plugin"
LD_PRELOAD=libsuperray-maps.so icp-slam \
    /usr/share/superray/config_files/icp-slam-superray.ini "$laser" </dev/null >icp.log 2>&1 ||
    { tail -n 20 icp.log >&2; exit 1; }
grep "map classes registered" icp.log
ls LOG_ICP-SLAM_SUPERRAY/*superray__*.srmap

step "stock rawlog-edit with the plugin"
rawlog-edit -p libsuperray-maps.so --info -i "$datasets/tests_rgbd.rawlog" >edit.log 2>&1 ||
    { tail -n 20 edit.log >&2; exit 1; }
grep "map classes registered" edit.log

step "a project that finds the development package"
apt-get -qq install --yes --no-install-recommends "$packages"/*.deb g++ cmake make >/dev/null
for project in share/examples/embed tests/system/consumer; do
    cmake -S "$source_dir/$project" -B "$work/build/$project" -DCMAKE_BUILD_TYPE=Release >/dev/null
    cmake --build "$work/build/$project" >/dev/null
done
[[ $(build/tests/system/consumer/core_only) == "4 cells" ]]
build/share/examples/embed/embed | grep "40 cells occupied"
superray-map info wall.srmap >/dev/null
ls /usr/share/doc/superray-doc/README.md /usr/share/superray/examples/embed/main.cpp
step "packages: all right"
