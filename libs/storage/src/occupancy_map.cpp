// SPDX-License-Identifier: BSD-3-Clause
#include <superray/storage/occupancy_map.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace superray {

namespace {

template <int Dim>
void include(const Cell<Dim>& c, MapSummary<Dim>& s) {
    for (int a = 0; a < Dim; ++a) {
        s.lowest[a] = std::min(s.lowest[a], c[a]);
        s.highest[a] = std::max(s.highest[a], c[a]);
    }
}

}  // namespace

template <int Dim>
MapSummary<Dim> summarize(const OccupancyMap<Dim>& map, const SensorModel& model) {
    constexpr int kCells = kBlockCells<Dim>;
    MapSummary<Dim> s;
    s.lowest.fill(std::numeric_limits<std::int32_t>::max());
    s.highest.fill(std::numeric_limits<std::int32_t>::min());
    const float occupied = model.occupied();
    map.forEachBlock([&](const BlockView<Dim>& block) {
        const auto isOccupied = [&](float value) { return value >= occupied; };
        if (block.known.all()) {  // most of a large map, and all of its uniform blocks
            const auto n = std::count_if(block.values, block.values + kCells, isOccupied);
            s.known += kCells;
            s.occupied += static_cast<std::uint64_t>(n);
            include(cellInBlock<Dim>(block.key, 0), s);
            include(cellInBlock<Dim>(block.key, kCells - 1), s);
            return;
        }
        for (int i = 0; i < kCells; ++i) {
            if (!block.known.test(i)) continue;
            ++s.known;
            s.occupied += isOccupied(block.values[i]);
            include(cellInBlock<Dim>(block.key, i), s);
        }
    });
    s.free = s.known - s.occupied;
    if (s.known == 0) s.lowest = s.highest = {};
    return s;
}

namespace {

/// A bijection whose every output bit depends on every input bit.
std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 32)) * 0xD6E8FEB86659FD93ull;
    x = (x ^ (x >> 29)) * 0xA0761D6478BD642Full;
    return x ^ (x >> 32);
}

/// Two independent 64-bit hashes, fed word by word.
struct Hash128 {
    std::uint64_t a, b;
    void add(std::uint64_t word) {
        a = mix(a ^ word);
        b = mix(b + word * 0xE7037ED1A0B428DBull + 0x8EBC6AF09C88C6E3ull);
    }
};

template <typename To, typename From>
To bitsOf(From value) {
    static_assert(sizeof(To) == sizeof(From));
    To bits;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}

std::string hex(std::uint64_t v) {
    std::string s(16, '0');
    for (int i = 15; i >= 0; --i, v >>= 4)
        s[static_cast<std::size_t>(i)] = "0123456789abcdef"[v & 15];
    return s;
}

}  // namespace

// The sum over the cells of a strong hash of (cell, value bits): a sum does not
// depend on the order. Equal values have equal bits, for storages keep no -0.
template <int Dim>
std::string contentDigest(const OccupancyMap<Dim>& map) {
    std::uint64_t sumA = 0, sumB = 0, cells = 0;
    map.forEachBlock([&](const BlockView<Dim>& block) {
        Hash128 ofBlock{0x2D358DCCAA6C78A5ull, 0x8BB84B93962EACC9ull};
        for (const std::int32_t k : block.key) ofBlock.add(static_cast<std::uint32_t>(k));
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!block.known.test(i)) continue;
            Hash128 ofCell = ofBlock;
            ofCell.add(std::uint64_t{bitsOf<std::uint32_t>(block.values[i])} << 32 |
                       static_cast<std::uint32_t>(i));
            sumA += ofCell.a;
            sumB += ofCell.b;
            ++cells;
        }
    });
    Hash128 total{sumA, sumB};
    total.add(bitsOf<std::uint64_t>(map.geometry().resolution()));
    total.add(static_cast<std::uint64_t>(Dim));
    total.add(cells);
    return hex(total.a) + hex(total.b);
}

template class OccupancyMap<2>;
template class OccupancyMap<3>;
template MapSummary<2> summarize<2>(const OccupancyMap<2>&, const SensorModel&);
template MapSummary<3> summarize<3>(const OccupancyMap<3>&, const SensorModel&);
template std::string contentDigest<2>(const OccupancyMap<2>&);
template std::string contentDigest<3>(const OccupancyMap<3>&);

}  // namespace superray
