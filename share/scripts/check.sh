#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Gates on the sources: check.sh [--quick]
#   --quick  marks of merges, formatting, includes and the licence line only (what the
#            commit hook runs); else also the pages of the headers, clang-tidy on what
#            changed lately, and a project that uses superray::core and
#            superray::storage alone
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
if git grep -nE '^(<<<<<<<|>>>>>>>) '; then
    echo "error: these lines are left from a merge" >&2
    exit 1
fi
format=$(command -v clang-format-14 || command -v clang-format)

git ls-files -z 'libs/*.h' 'libs/*.cpp' 'apps/*.h' 'apps/*.cpp' 'tests/*.h' 'tests/*.cpp' \
    | xargs -0 "$format" --dry-run -Werror
python3 -B share/scripts/check_includes.py
python3 -B share/scripts/spdx.py --check
version=$(sed -n 's/.*define SUPERRAY_VERSION "\(.*\)"/\1/p' libs/core/include/superray/core/version.h)
grep -q "^## $version" CHANGELOG.md && grep -qx "version: $version" CITATION.cff || {
    echo "error: CHANGELOG.md or CITATION.cff lack version $version of version.h" >&2
    exit 1
}
[[ ${1:-} != --quick ]] || exit 0
bash share/scripts/api_docs.sh
bash share/scripts/consumer_core.sh
bash share/scripts/tidy.sh
