#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Maps real scans: demo.sh [OUTDIR]     (OUTDIR: default ./out)
# Uses the recorded scans that Debian's mrpt-common ships. Installs what is
# missing, builds, and leaves maps, an OctoMap file, 3D scenes and pictures.
set -euo pipefail
out=${1:-out}
mkdir -p "$out"
out=$(cd "$out" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
datasets=/usr/share/mrpt/datasets
laser_rawlog="$datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"

say() { printf '\n=== %s\n' "$*"; }

say "Installing what is missing, building"
bash share/scripts/install_deps.sh
options=()
! command -v ccache >/dev/null || options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
[[ ${CI:-} != true ]] || options+=(-DSUPERRAY_WERROR=ON) # as test.sh, which builds on
cmake --preset release ${options[@]+"${options[@]}"} >"$out/build.log"
cmake --build --preset release --parallel "$(nproc)" \
    --target superray-map superray-maps >>"$out/build.log" || {
    tail -n 30 "$out/build.log" >&2
    exit 1
}
superray_map=build/release/apps/superray-map/superray-map
plugin=$PWD/build/release/libs/maps/libsuperray-maps.so

# map NAME RAWLOG OPTIONS...: a map and everything made from it
map() {
    local name=$1 rawlog=$2
    shift 2
    "$superray_map" build "$rawlog" -o "$out/$name.srmap" "$@"
    "$superray_map" info "$out/$name.srmap" --json >"$out/$name.json"
    for format in ot ply 3Dscene png; do
        "$superray_map" export "$out/$name.srmap" "$out/$name.$format"
    done
    "$superray_map" compare "$out/$name.srmap" "$out/$name.ot"
}

say "A room, seen by an RGB-D camera (one observation, range image)"
map room "$datasets/tests_rgbd.rawlog" --fixed-robot --resolution 0.02

say "A street, seen by a Velodyne VLP-16 (one scan, raw packets)"
map street "$datasets/test_velodyne_VLP16.rawlog" --fixed-robot --resolution 0.2 \
    --max-range 25

say "A loop through a building: stock icp-slam with the plugin (laser and odometry)"
(
    cd "$out"
    LD_PRELOAD=$plugin icp-slam "$OLDPWD/share/config_files/icp-slam-superray.ini" \
        "$laser_rawlog" </dev/null >icp-slam.log 2>&1 ||
        { tail -n 30 icp-slam.log >&2; exit 1; }
)
slam_maps=("$out"/LOG_ICP-SLAM_SUPERRAY/*superray__*.srmap)
for slam_map in "${slam_maps[@]}"; do
    [[ -f $slam_map ]] || { echo "error: icp-slam left no map of the plugin" >&2; exit 1; }
    "$superray_map" info "$slam_map" | head -n 7
    class=${slam_map##*superray__}
    "$superray_map" export "$slam_map" "$out/loop_${class%%_*}.png"
    cp "${slam_map%.srmap}.3Dscene" "$out/loop_${class%%_*}.3Dscene"
done

say "Left in $out"
(cd "$out" && ls -1 -- *.srmap *.ot *.ply *.3Dscene *.png)
cat <<END

Look at them:
  the pictures      any viewer, e.g. xdg-open $out/room.png
  the maps in 3D    SceneViewer3D $out/room.3Dscene
  in OctoMap        octovis $out/room.ot   (Debian package octovis)
  the numbers       $superray_map info $out/room.srmap
END
