// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file file_bytes.h
/// Files as bytes, and what readers of clouds share.

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace superray {

/// The contents of a regular file, or their first `most` bytes.
/// \throws InputError if it cannot be read, has more than 4 GiB, or is no regular file (a
///         device may never end)
std::string readFileBytes(const std::string& path,
                          std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

/// The first bytes of a file, fewer if it is shorter or cannot be read.
std::string startOfFile(const std::string& path);

/// True if bytes after the data, up to `end`, are only blanks, line ends and zeros, as some
/// writers fill up a file with.
bool isPadding(const std::string& bytes, std::size_t from, std::size_t end = std::string::npos);

/// The words of a line, which blanks separate.
std::vector<std::string> wordsOf(const std::string& line);

}  // namespace superray
