// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file input_file.h
/// Whole files in.

#include <string>

#include "file/byte_io.h"

namespace superray {

/// \throws MapFileError, also if `path` is not a regular file
Bytes readWholeFile(const std::string& path);

}  // namespace superray
