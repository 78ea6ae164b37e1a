// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The share of one minor axis in the address of a cell.

#include "kernels/simd/lanes.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

/// An address is a sum over the axes. The part of a minor axis has two fields. Bit `minor`
/// tells whether the cell's block is an odd one: which of two blocks is meant. From
/// kPickBits on stands where the cell is in its block, times the stride of the axis.
/// It depends on the lowest 4 bits of the cell only, so neighbours have different ones.
///
/// Example, axis 1 (stride 8), minor 0, no flip: cell 13 = 8 + 5 is number 5 of an odd
/// block: part = 1 | (5 * 8) << 2 = 161.
///
/// \param cells mirrored cell numbers
/// \param flip -1 if the axis is mirrored, else 0
template <int minor, int axis>
SUPERRAY_INLINE Ints addressPart(Ints cells, Ints flip) {
    const Ints inBlock = (cells ^ flip) & (kBlockEdge - 1);
    const Ints odd = cells & kBlockEdge;
    return inBlock << (kBlockBits * axis + kPickBits) | odd >> (kBlockBits - minor);
}

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
