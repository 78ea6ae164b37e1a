#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes the pages of the public headers, build/api/html/index.html. Any warning of
# Doxygen is an error.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p build
doxygen doc/Doxyfile
echo "public headers: build/api/html/index.html, no warning"
