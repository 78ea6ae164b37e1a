// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which counts of a block are large enough.

#include <superray/core/block.h>

#include "kernels/simd/lanes.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// As AtLeast.
template <typename Simd, int Dim>
BlockMask<Dim> atLeast(const std::uint8_t* counts, std::uint32_t least) {
    BlockMask<Dim> mask;
    for (int w = 0; w < BlockMask<Dim>::kWords; ++w)
        mask.words[static_cast<std::size_t>(w)] = Simd::atLeast64(counts + 64 * w, least);
    return mask;
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
