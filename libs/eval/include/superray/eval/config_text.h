// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file config_text.h
/// Configuration files, checked for what MRPT's reader lets pass.

#include <string>

namespace superray {

/// The text of an .ini file, for mrpt::config::CConfigFileMemory.
/// \throws InputError if it cannot be read, is no regular file or too large, or if a
///         section, or a key within a section, occurs twice (MRPT takes one of them)
std::string readConfigText(const std::string& path);

}  // namespace superray
