#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks that every way to build a map gives the same map, on whole recordings:
# all methods, 1 and 2 threads, both 3D classes. Long; run by hand:
#
#   verify_digests.sh [--scans N] [--policy P] [--program superray-map]
#                     FILE.rawlog@RESOLUTION...
#
# e.g. verify_digests.sh room.rawlog@0.05 hall.rawlog@0.1 hall.rawlog@0.2
# Prints one line per recording, resolution, class, method and number of
# threads. Exit code: 0 all equal, 1 not, 2 error.
set -euo pipefail
program=$(dirname "${BASH_SOURCE[0]}")/../../build/release/apps/superray-map/superray-map
options=()
inputs=()
usage() {
    echo "usage: $0 [--scans N] [--policy P] [--program superray-map]" \
        "FILE.rawlog@RESOLUTION..." >&2
    exit 2
}
while [[ $# -gt 0 ]]; do
    case $1 in
        --scans) [[ $# -gt 1 ]] || usage; options+=(--scans "$2"); shift 2 ;;
        --policy) [[ $# -gt 1 ]] || usage; options+=(--policy "$2"); shift 2 ;;
        --program) [[ $# -gt 1 ]] || usage; program=$2; shift 2 ;;
        *@*) inputs+=("$1"); shift ;;
        *) usage ;;
    esac
done
[[ ${#inputs[@]} -gt 0 ]] || usage
[[ -x $program ]] || { echo "error: no program $program" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
different=0
checked=0
printf '%-18s %-6s %-19s %-10s %-8s %-9s %s\n' \
    recording res class method threads seconds digest
for input in "${inputs[@]}"; do
    rawlog=${input%@*}
    resolution=${input##*@}
    name=$(basename "$rawlog" .rawlog)
    expected=
    for class in CSuperRayGridMap3D CSuperRayOctoMap; do
        for method in reference perRay superRays culling full auto; do
            for threads in 1 2; do
                started=$(date +%s.%N)
                "$program" build "$rawlog" -o "$work/map.srmap" --map "$class" \
                    --resolution "$resolution" --method "$method" --threads "$threads" \
                    ${options[@]+"${options[@]}"} >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 2; }
                seconds=$(echo "$(date +%s.%N) $started" | awk '{printf "%.1f", $1 - $2}')
                digest=$("$program" info "$work/map.srmap" --json |
                    sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p')
                [[ ${#digest} -eq 32 ]] || { echo "error: no digest" >&2; exit 2; }
                : "${expected:=$digest}"
                verdict=
                [[ $digest == "$expected" ]] || { verdict=DIFFERENT; different=1; }
                checked=$((checked + 1))
                printf '%-18s %-6s %-19s %-10s %-8s %-9s %s %s\n' "$name" "$resolution" \
                    "$class" "$method" "$threads" "$seconds" "$digest" "$verdict"
            done
        done
    done
done
if [[ $different -ne 0 ]]; then
    echo "NOT all equal ($checked maps)"
    exit 1
fi
echo "All $checked maps: equal per recording and resolution"
