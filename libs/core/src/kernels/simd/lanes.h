// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Vectors of 8 lanes as GCC and clang know them: + - & | ^ << >> == < act on
// each lane, v[i] is lane i, and a comparison gives -1 (all bits) in the lanes
// where it holds, 0 in the others. With AVX2 each is one register; elsewhere
// the compiler splits them.

#include <superray/core/block.h>
#include <superray/core/detail/always_inline.h>

#include <cstdint>

/// Before a loop: no iteration reads what another one writes.
#if defined(__clang__)
#define SUPERRAY_INDEPENDENT_ITERATIONS _Pragma("clang loop vectorize(assume_safety)")
#else
#define SUPERRAY_INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif

namespace superray {

using Ints = std::int32_t __attribute__((vector_size(32)));
using UInts = std::uint32_t __attribute__((vector_size(32)));

/// The m-th axis, ascending, that is not the major one.
/// Example: minorAxis<1>(0) == 0 and minorAxis<1>(1) == 2: x and z, of a ray
/// along y.
template <int major>
constexpr int minorAxis(int m) {
    return m < major ? m : m + 1;
}

/// Low bits of the part of an address that stand for the block, see
/// addressPart().
inline constexpr int kPickBits = 2;

}  // namespace superray
