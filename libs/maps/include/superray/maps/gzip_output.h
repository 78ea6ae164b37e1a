// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file gzip_output.h
/// MRPT objects in files that every MRPT opens.

#include <mrpt/serialization/CSerializable.h>

#include <string>

namespace superray {

/// Writes one object (a scene, a simplemap) to a gzip file. The `saveToFile` of
/// MRPT's classes writes zstd from 2.15.7 on, which no earlier MRPT opens.
/// \return false if the file cannot be opened
/// \throws std::exception if it cannot be written
bool writeGzip(const mrpt::serialization::CSerializable& object, const std::string& path);

}  // namespace superray
