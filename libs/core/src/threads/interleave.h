// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// An order of steps for loops whose neighbouring steps often change the same value.

#include <cstddef>

namespace superray {

/// Calls step(lane, i) once for each i = 0 .. count - 1, from the four quarters of the range in
/// turn: with count = 8, i = 0 2 4 6 1 3 5 7. Steps i and i + 1, which may need the same
/// value, are then four calls apart, so none waits for the store of the one before.
template <typename Step>
inline void interleave(std::size_t count, const Step& step) {
    const std::size_t quarter = count / 4;
    for (std::size_t i = 0; i < quarter; ++i)
        for (std::size_t lane = 0; lane < 4; ++lane) step(lane, lane * quarter + i);
    for (std::size_t i = 4 * quarter; i < count; ++i) step(std::size_t{3}, i);
}

}  // namespace superray
