// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file atomic_file.h
/// Whole files in and out.

#include "file/byte_io.h"

#include <string>

namespace superray {

/// Writes beside `path`, syncs and renames: `path` holds either the old or the
/// new contents, whatever happens. A symbolic link is followed.
/// \throws MapFileError; the temporary file is removed then
void writeFileAtomically(const std::string& path, const Bytes& contents);

/// \throws MapFileError, also if `path` is not a regular file
Bytes readWholeFile(const std::string& path);

}  // namespace superray
