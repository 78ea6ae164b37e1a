// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file depth_image.h

#include <mrpt/math/CMatrixDynamic.h>

#include <cstdint>
#include <string>

namespace superray {

/// Reads a PNG of one channel of 16 bits. \throws InputError naming the file and the rule
mrpt::math::CMatrixDynamic<std::uint16_t> readDepthPng(const std::string& path);

}  // namespace superray
