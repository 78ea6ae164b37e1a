// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a block of a block grid consists of, in the map and on its way into it.

#include <superray/core/block.h>

#include "containers/block_table.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace superray::grid {

/// Values of 64 cells (one BlockMask word), 0 where not known.
struct alignas(64) Layer {
    std::array<float, 64> values;
};
inline constexpr std::uint32_t kNoLayer = ~std::uint32_t{0};

/// A block that is not uniform. Layers without known cells take no memory.
template <int Dim>
struct alignas(64) Payload {
    static constexpr int kLayers = BlockMask<Dim>::kWords;
    Payload() { layers.fill(kNoLayer); }
    BlockMask<Dim> saturated;  // known cells at the lower clamp; asked for most
    BlockMask<Dim> known;
    std::array<std::uint32_t, kLayers> layers;
};

inline constexpr std::uint32_t kAbsent = ~std::uint32_t{0};
inline constexpr std::uint32_t kUniform = kAbsent - 1;

/// A block is absent (no known cells), uniform (all cells known, one value) or has a
/// payload.
struct Block {
    std::uint32_t payload = kAbsent;
    float highest = 0;  ///< the one value; else no cell has log-odds above it
};
inline constexpr float kAnyLogOdds = std::numeric_limits<float>::infinity();

/// A block of a batch on its way into the map.
template <int Dim>
struct Pending {
    static constexpr int kLayers = Payload<Dim>::kLayers;

    BlockMask<Dim> touched;
    typename BlockTable<Dim, Block>::Place place;  ///< may be nowhere until blocks are made
    Payload<Dim>* payload;                         ///< nullptr: nothing to do
    std::array<float*, kLayers> values;            ///< of touched layers
    std::array<std::uint32_t, kLayers> made;       ///< numbers of new layers
    std::uint32_t fresh;  ///< bit z: layer z is new, its values unspecified
    bool freshPayload;    ///< the payload is new, its contents unspecified

    /// Fills in what is new: no cell is known. Threads may do this at once.
    void fillIn() {
        if (payload == nullptr) return;
        if (freshPayload) *payload = Payload<Dim>{};
        freshPayload = false;
        for (; fresh != 0; fresh &= fresh - 1) {
            const int z = __builtin_ctz(fresh);
            payload->layers[z] = made[z];
            std::fill_n(values[z], 64, 0.0f);
        }
    }
};

}  // namespace superray::grid
