#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Prints one line "NAME POLICY DIGEST" per map, made by the programs of a build:
#
#   release_digests.sh [--build DIR] [--data DIR]
#
#   --build DIR   build folder; default: build/release of this repository
#   --data DIR    folder with more recordings; default: ../shared/data beside it
#
# Maps are the same bits on every release, compiler and processor: compare the
# output of two builds with diff. Recordings that are not there are skipped, and
# standard error says so. Exit code: 0 all maps made, 1 a program failed, 2 usage.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/release
data=$root/../shared/data
while [[ $# -gt 0 ]]; do
    case $1 in
        --build) build=${2:?--build needs a folder}; shift 2 ;;
        --data) data=${2:?--data needs a folder}; shift 2 ;;
        *) echo "usage: $0 [--build DIR] [--data DIR]" >&2; exit 2 ;;
    esac
done
build=$(cd "$build" && pwd)
superray_map=$build/apps/superray-map/superray-map
plugin=$build/libs/maps/libsuperray-maps.so
for file in "$superray_map" "$plugin"; do
    [[ -e $file ]] || { echo "error: no $file" >&2; exit 2; }
done
datasets=/usr/share/mrpt/datasets

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

skip() { echo "SKIPPED: $1" >&2; }

policies=(everyRay netEvidence)

# line NAME POLICY MAP
line() {
    local digest
    digest=$("$superray_map" info "$3" --json | sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p')
    [[ ${#digest} -eq 32 ]] || { echo "error: no digest of $1" >&2; exit 1; }
    echo "$1 $2 $digest"
}

# map NAME RAWLOG OPTIONS...
map() {
    local name=$1 rawlog=$2 policy
    shift 2
    [[ -f $rawlog ]] || { skip "$name: no $rawlog"; return 0; }
    for policy in "${policies[@]}"; do
        "$superray_map" build "$rawlog" -o "$work/map.srmap" --policy "$policy" "$@" \
            >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
        line "$name" "$policy" "$work/map.srmap"
    done
}

# icp_slam RAWLOG: stock icp-slam with two maps of the plugin
icp_slam() {
    local policy class maps
    for policy in "${policies[@]}"; do
        sed "s/^\[.*_superRay.*_insertOpts\]\$/&\npolicy = $policy/" \
            "$root/share/config_files/icp-slam-superray.ini" >"$work/icp-slam.ini"
        (cd "$work" && LD_PRELOAD=$plugin icp-slam icp-slam.ini "$1" </dev/null >log 2>&1) ||
            { tail -n 30 "$work/log" >&2; exit 1; }
        for class in CSuperRayGridMap2D CSuperRayOctoMap; do
            maps=("$work"/LOG_ICP-SLAM_SUPERRAY/*superray__"$class"_*.srmap)
            line "icp_slam_$class" "$policy" "${maps[0]}"
        done
        rm -r "$work/LOG_ICP-SLAM_SUPERRAY"
    done
}

map room_0.02 "$datasets/tests_rgbd.rawlog" --fixed-robot --resolution 0.02
map street_0.2 "$datasets/test_velodyne_VLP16.rawlog" --fixed-robot --resolution 0.2 \
    --max-range 25

laser=$datasets/"2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"
if ! command -v icp-slam >/dev/null; then
    skip "icp_slam: no stock icp-slam"
elif [[ ! -f $laser ]]; then
    skip "icp_slam: no $laser"
else
    icp_slam "$laser"
fi

map kitti_0.2 "$data/kitti_hdl64.rawlog" --resolution 0.2
map hall_0.1 "$data/ouster_hall.rawlog" --resolution 0.1
