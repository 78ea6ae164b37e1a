// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octomap_file.h
/// OctoMap's files as inputs of programs.

#include <superray/eval/input_error.h>
#include <superray/maps/octomap_input.h>

namespace superray {

/// loadOctomapFile() with this library's error. \throws InputError
inline OctomapFile readOctomapFile(const std::string& path, const OctomapLimits& limits = {}) {
    try {
        return loadOctomapFile(path, limits);
    } catch (const MapFileError& e) {
        throw InputError(e.what());
    }
}

}  // namespace superray
