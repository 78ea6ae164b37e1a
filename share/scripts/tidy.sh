#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Runs clang-tidy with the checks of .clang-tidy; a finding is an error.
#
#   tidy.sh              the sources of libs and apps that the last 5 commits, or
#                        changes that are not committed, have touched
#   tidy.sh --since REV  those touched since REV
#   tidy.sh --all        all of them (about half an hour on two cores)
#   tidy.sh FILE...      these
#
# Configures build/tidy for the list of compile commands. Exit code: 0 no finding,
# 1 findings, 2 usage.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
tidy=$(command -v clang-tidy-14 || command -v clang-tidy)
sources=('libs/*.cpp' 'apps/*.cpp')

touched_since() {
    git diff --name-only --diff-filter=d "$1" -- "${sources[@]}"
}

case ${1:-} in
    --all) files=$(git ls-files "${sources[@]}") ;;
    --since) [[ $# -eq 2 ]] || { sed -n '3,12s/^# \{0,1\}//p' "$0" >&2; exit 2; }
             files=$(touched_since "$2") ;;
    -*) sed -n '3,12s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
    "") base=$(git rev-list --first-parent --max-count=6 HEAD | tail -n 1)
        files=$(touched_since "$base") ;;
    *) files=$(printf '%s\n' "$@") ;;
esac
count=$(grep -c . <<<"$files" || true)
echo "clang-tidy: $count sources"
((count)) || exit 0

mkdir -p build
cmake -S . -B build/tidy -G Ninja -DCMAKE_BUILD_TYPE=Debug -DSUPERRAY_BUILD_TESTS=OFF \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON >build/tidy.log 2>&1 || { cat build/tidy.log >&2; exit 1; }
# The count of warnings that are not ours goes to standard error.
if ! xargs -P "$(nproc)" -n 1 "$tidy" -p build/tidy --quiet -warnings-as-errors='*' \
    <<<"$files" 2>build/tidy.log; then
    grep -v 'warnings generated\.$' build/tidy.log >&2 || true
    echo "error: clang-tidy has findings" >&2
    exit 1
fi
