// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file text_input.h
/// Text files of limited size.

#include <cstdint>
#include <sstream>
#include <string>

namespace superray {

enum class LastLine : std::uint8_t {
    any,
    mustEnd  ///< by a line feed: else its last number may be cut off
};

/// The contents of a regular file.
/// \throws InputError if it cannot be read, is larger than 256 MiB, is no regular file
///         (a device may never end), or its last line has no end but must have one
std::istringstream openTextInput(const std::string& path, LastLine lastLine);

}  // namespace superray
