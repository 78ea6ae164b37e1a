// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file png_output.h
/// Pictures as files, whole or not at all.

#include <mrpt/img/CImage.h>

#include <string>

namespace superray {

/// Writes an 8-bit grey or colour picture as PNG, by the rules of AtomicFile (the
/// `saveToFile` of CImage leaves a cut file on a full disk).
/// \throws MapFileError
void writePng(const mrpt::img::CImage& image, const std::string& path);

}  // namespace superray
