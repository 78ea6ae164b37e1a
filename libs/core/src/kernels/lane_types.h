// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the kernels of all instruction sets have in common.

#include <cstdint>

namespace superray {

using Ints = std::int32_t __attribute__((vector_size(32)));

/// The m-th axis, ascending, that is not the major one.
template <int major>
constexpr int minorAxis(int m) {
    return m < major ? m : m + 1;
}

}  // namespace superray
