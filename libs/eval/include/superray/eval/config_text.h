// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file config_text.h
/// Configuration files, checked for what MRPT's reader lets pass.

#include <mrpt/config/CConfigFileMemory.h>

#include <functional>
#include <string>

namespace superray {

/// An .ini file, of which a program reads some sections.
/// \param isRead whether the program reads a section (its name in lower case). Others may
///        be of other programs, which read their lines in another way
/// \throws InputError naming file and line if it cannot be read, is no regular file or too
///         large; if a section, or a key within a section, occurs twice (MRPT takes one of
///         them); or if there is a line that MRPT would skip without a word
mrpt::config::CConfigFileMemory readConfigFile(
    const std::string& path, const std::function<bool(const std::string&)>& isRead);

}  // namespace superray
