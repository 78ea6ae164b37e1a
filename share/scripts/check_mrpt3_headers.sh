#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Compiles libs/maps against the headers of another MRPT, without making anything:
#   check_mrpt3_headers.sh HEADERS_DIR [FILE...]
#   HEADERS_DIR  a source tree of MRPT 3 (modules/mrpt_*/include), an installed one
#                (include/mrpt_*/include or include/mrpt/*/include), or a folder with mrpt/
#   FILE         of libs/maps/src; default: all .cpp files
# CXX, CXXFLAGS and EIGEN_INCLUDE are heeded. Exit code: 0 if all files compile, 1 if any
# does not, 2 if the headers or files are not found. Headers that the build of MRPT
# generates (mrpt/version.h) must be there: configure a source tree first, and put the
# folders with its generated headers in CPATH.
set -euo pipefail

if [[ $# -lt 1 || $1 == -h || $1 == --help ]]; then
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
  [[ $# -ge 1 ]] && exit 0
  exit 2
fi
if [[ ! -d $1 ]]; then
  echo "error: '$1' is not a folder; it must hold the headers of MRPT" >&2
  exit 2
fi
headers=$(cd "$1" && pwd)
shift
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

# Every folder in which a module's mrpt/... lies.
includes=()
for folder in "$headers" "$headers"/modules/mrpt_*/include "$headers"/include \
  "$headers"/include/mrpt_*/include "$headers"/include/mrpt/*/include \
  "$headers"/mrpt/*/include "$headers"/mrpt_*/include; do
  [[ -d $folder/mrpt ]] && includes+=(-isystem "$folder")
done
compiler=${CXX:-c++}
flags=(-std=c++17 -Wall -Wextra -DSUPERRAY_VERSION="\"check\"" ${CXXFLAGS:-})
flags+=(-Ilibs/maps/include -Ilibs/maps/src -Ilibs/storage/include -Ilibs/core/include
  ${includes[@]+"${includes[@]}"} -isystem "${EIGEN_INCLUDE:-/usr/include/eigen3}")

version=$(printf '#include <mrpt/version.h>\nsuperray_version MRPT_VERSION\n' |
  "$compiler" -x c++ -E -P "${flags[@]}" - 2>/dev/null | tr -s '\n' ' ' |
  sed -n 's/.*superray_version *//p') || true
version=${version%% }
if [[ $version != 0x* ]]; then
  echo "error: no mrpt/version.h below '$headers' or in CPATH" >&2
  exit 2
fi
echo "MRPT_VERSION is $version"

files=("$@")
if [[ ${#files[@]} -eq 0 ]]; then
  mapfile -t files < <(find libs/maps/src -name '*.cpp' | LC_ALL=C sort)
fi
for file in "${files[@]}"; do
  [[ -f $file ]] || { echo "error: no file '$file'" >&2; exit 2; }
done

failed=0 count=0
for file in "${files[@]}"; do
  count=$((count + 1))
  if ! "$compiler" -fsyntax-only "${flags[@]}" "$file"; then
    echo "does not compile: $file"
    failed=$((failed + 1))
  fi
done
echo "$((count - failed)) of $count files of libs/maps compile"
[[ $failed -eq 0 ]]
