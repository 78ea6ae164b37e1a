// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file linear_probing.h
/// What hash tables of open addressing with linear probing share.

#include <cstddef>
#include <vector>

namespace superray::detail {

/// Empties a slot of a table whose size is a power of two. Entries that were put off by this
/// one move up, so that no search ends too early.
/// \param hole the slot; not free
/// \param isFree `isFree(slot)`, true for Slot{}
/// \param home `home(slot)`: where its entry goes if nothing is there
template <typename Slot, typename IsFree, typename Home>
void emptySlot(std::vector<Slot>& slots, std::size_t hole, const IsFree& isFree,
               const Home& home) {
    const std::size_t mask = slots.size() - 1;
    for (std::size_t i = (hole + 1) & mask; !isFree(slots[i]); i = (i + 1) & mask)
        if (((i - home(slots[i])) & mask) >= ((i - hole) & mask)) {
            slots[hole] = slots[i];
            hole = i;
        }
    slots[hole] = Slot{};
}

}  // namespace superray::detail
