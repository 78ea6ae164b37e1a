// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file output_paths.h
/// What can be known of outputs before the work that they are the result of.

#include <string>
#include <vector>

namespace superray {

/// Checks, before long work, that a file could be written at `path`.
/// \param extensions the ones allowed, e.g. {".srmap"}
/// \throws InputError naming the path and what is wrong with it
void checkOutputPath(const std::string& path, const std::vector<std::string>& extensions);

/// Refuses, before any work, an output that would overwrite an input or another output: the
/// same file, also by another name or a link. Devices and FIFOs overwrite nothing.
/// \throws InputError naming both
void checkOutputsApart(const std::vector<std::string>& inputs,
                       const std::vector<std::string>& outputs);

}  // namespace superray
