// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Loops whose neighbouring steps often change the same value.

#include <cstddef>

namespace superray {

/// Calls step(lane, i) for i = 0 .. count - 1, in an order that takes neighbours from
/// four lanes in turn: where they often need the same value, none waits for the store
/// of the one before.
template <typename Step>
inline void interleave(std::size_t count, const Step& step) {
    const std::size_t quarter = count / 4;
    for (std::size_t i = 0; i < quarter; ++i)
        for (std::size_t lane = 0; lane < 4; ++lane) step(lane, lane * quarter + i);
    for (std::size_t i = 4 * quarter; i < count; ++i) step(std::size_t{3}, i);
}

}  // namespace superray
