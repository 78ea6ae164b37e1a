// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file input_file.h
/// Whole files in.

#include <functional>
#include <string>

#include "file/byte_io.h"

namespace superray {

/// Called with the first bytes of a file (all, if it is shorter) and its size; throws if
/// the rest need not be read.
using CheckStart = std::function<void(const Bytes& start, std::uint64_t size)>;

/// \param startSize bytes that `check` wants
/// \param most throws if the file is larger
/// \throws MapFileError, also if `path` is not a regular file
Bytes readWholeFile(const std::string& path, std::size_t startSize, std::uint64_t most,
                    const CheckStart& check);

}  // namespace superray
