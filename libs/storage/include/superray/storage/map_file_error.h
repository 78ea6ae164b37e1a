// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_file_error.h
/// What reading and writing of map files throws.

#include <stdexcept>

namespace superray {

/// A file that is not what it should be: names the file, the place and the rule.
class MapFileError : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

}  // namespace superray
