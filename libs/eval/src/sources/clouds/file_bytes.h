// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file file_bytes.h
/// What the readers of cloud files share.

#include <string>
#include <vector>

namespace superray {

/// The contents of a regular file.
/// \throws InputError if it cannot be read, has more than 4 GiB, or is no regular file (a
///         device may never end)
std::string readFileBytes(const std::string& path);

/// True if bytes after the data are only blanks, line ends and zeros, as some writers
/// fill up a file with.
bool isPadding(const std::string& bytes, std::size_t from);

/// The words of a line, which blanks separate.
std::vector<std::string> wordsOf(const std::string& line);

}  // namespace superray
