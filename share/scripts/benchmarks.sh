#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Runs the protocol of doc/benchmarks.md: benchmarks.sh [OPTIONS]
#   --out DIR        where the results go; default ./benchmarks-out
#   --data DIR       recordings; rgbd_room.rawlog, ouster_hall.rawlog and
#                    kitti_hdl64.rawlog are used where they are there
#   --program FILE   superray-bench; default: that of build/release
#   --quick          few scans and coarse cells only: does everything work?
# Leaves JSON files and tables.md. Takes long; nothing else should run on the
# machine meanwhile.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
program=$root/build/release/apps/superray-bench/superray-bench
out=benchmarks-out
data=
quick=0
while [[ $# -gt 0 ]]; do
    case $1 in
        --out | --data | --program)
            [[ $# -gt 1 ]] || { echo "error: $1 needs a value" >&2; exit 1; }
            declare "${1#--}=$2"
            shift 2
            ;;
        --quick) quick=1; shift ;;
        *) sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 1 ;;
    esac
done
[[ -x $program ]] || { echo "error: no program $program; build superray-bench" >&2; exit 1; }
mkdir -p "$out"

# compare NAME INPUT RESOLUTIONS SCANS FEW: few maps a process, so that they do not
# compete for memory more than they must: our maps against octomap with one thread, by
# default and with the policy of the paper; our grid against MRPT's, all methods, two
# threads (and two maps at once, which is what they could reach); of few scans, for that
# takes octomap's time again and again, all of MRPT's maps, and the policy of octomap.
compare() {
    local name=$1 input=$2 resolutions=$3 scans=$4 few=$5 run
    echo "=== $name, $resolutions m" >&2
    local -A engines=(
        [maps]=octomap,grid,octree
        [grid3d]=mrpt-grid3d,grid
        [grid]=grid,grid-perRay,grid-superRays,grid-culling,grid-full
        [octree]=octree,octree-perRay,octree-culling
        [threads]=grid,octree,grid-copies,octree-copies
        [peers]=octomap,mrpt-octomap,mrpt-grid3d,grid
        [once]=octomap,grid,octree)
    local -A more=([maps]="--policies netEvidence,everyRay" [threads]="--threads 1,2"
        [once]="--policy oncePerScan")
    local -A used=([peers]=$few [once]=$few)
    for run in maps grid3d grid octree threads peers once; do
        # shellcheck disable=SC2086  # options are several words
        "$program" compare "$input" --resolutions "$resolutions" \
            --scans "${used[$run]:-$scans}" --engines "${engines[$run]}" ${more[$run]:-} \
            --figures "$out/$name-$run.json" >"$out/$name-$run.txt"
    done
}

# realtime NAME INPUT RATE RESOLUTION THREADS: as in the paper, and with whole scans.
realtime() {
    local name=$1 input=$2 rate=$3 resolution=$4 threads=$5
    echo "=== realtime $name, $rate Hz, $resolution m" >&2
    local common=(realtime "$input" --rate "$rate" --resolution "$resolution"
        --engines octomap,mrpt-octomap,mrpt-grid3d,grid,octree --threads "$threads")
    ((quick == 0)) || common+=(--scans 3)
    "$program" "${common[@]}" --figures "$out/realtime-$name.json" >"$out/realtime-$name.txt"
    "$program" "${common[@]}" --keep-all-points --figures "$out/realtime-$name-all.json" \
        >"$out/realtime-$name-all.txt"
}

# As many scans as octomap takes a few minutes for.
if ((quick)); then
    compare indoor indoor 0.4 3 2
    compare outdoor outdoor 1.0 1 1
else
    compare indoor indoor 0.1,0.2,0.4,0.8,1.0 66 10
    compare outdoor outdoor 0.2,0.4,0.8,1.0 12 3
    compare outdoor-fine outdoor 0.1 5 2
fi
for recording in "rgbd_room 0.05 0.02 50 10 30 0.05 2" "ouster_hall 0.2 0.1 30 5 10 0.2 1" \
    "kitti_hdl64 0.2 0.1 12 3 10 0.2 1" "kitti_hdl64 - - - - 10 0.1 2"; do
    read -r name coarse fine scans few rate resolution threads <<<"$recording"
    file=$data/$name.rawlog
    if [[ -z $data || ! -f $file ]]; then
        echo "NOT MEASURED: $name (no $name.rawlog in --data)" >&2
        continue
    fi
    if [[ $coarse != - ]]; then
        if ((quick)); then
            compare "$name" "$file" "$coarse" 1 1
        else
            compare "$name" "$file" "$coarse,$fine" "$scans" "$few"
        fi
    fi
    realtime "$name-$resolution" "$file" "$rate" "$resolution" "$threads"
done

python3 "$root/share/scripts/benchmark_tables.py" "$out"/*.json >"$out/tables.md"
echo "Results in $out, tables in $out/tables.md" >&2
