#pragma once
// Loops whose neighbouring steps often change the same value.

#include <cstddef>

namespace superray {

/// Calls step(place, i) for i = 0 .. count - 1, in an order that takes neighbours from
/// four places in turn: where they often need the same value, none waits for the store
/// of the one before.
template <typename Step>
inline void inTurns(std::size_t count, const Step& step) {
    const std::size_t quarter = count / 4;
    for (std::size_t i = 0; i < quarter; ++i)
        for (std::size_t place = 0; place < 4; ++place) step(place, place * quarter + i);
    for (std::size_t i = 4 * quarter; i < count; ++i) step(std::size_t{3}, i);
}

}  // namespace superray
