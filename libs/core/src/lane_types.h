#pragma once
// Vectors of 8, which GCC and Clang split where a processor has shorter ones.

#include <cstdint>

namespace superray {

using Longs = std::int64_t __attribute__((vector_size(64)));
using Ints = std::int32_t __attribute__((vector_size(32)));
using Doubles = double __attribute__((vector_size(64)));

/// The m-th axis, ascending, that is not the dominant one.
template <int dominant>
constexpr int minorAxis(int m) {
    return m < dominant ? m : m + 1;
}

}  // namespace superray
