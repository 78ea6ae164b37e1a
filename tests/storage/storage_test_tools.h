// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file storage_test_tools.h
/// Random batches, and the oracle that every storage is held to.

#include <superray/storage/block_grid.h>
#include <superray/storage/octree.h>
#include <superray/storage/quadtree.h>

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <random>

namespace superray::test {

inline std::uint32_t bitsOf(float v) {
    std::uint32_t b;
    std::memcpy(&b, &v, sizeof b);
    return b;
}

template <int Dim>
using Cells = std::map<Cell<Dim>, float>;

/// The slow, obvious map: one cell at a time, by SensorModel::updated().
template <int Dim>
void applyToOracle(Cells<Dim>& oracle, const UpdateBatch<Dim>& batch, const SensorModel& model,
                   UpdatePolicy policy) {
    for (std::size_t b = 0; b < batch.blockCount(); ++b)
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            const std::uint32_t m = batch.misses(b)[i];
            const std::uint32_t h = batch.hits(b) ? batch.hits(b)[i] : 0;
            if (m == 0 && h == 0) continue;
            float& value = oracle[cellInBlock<Dim>(batch.key(b), i)];  // 0 if new
            value = model.updated(value, m, h, policy);
        }
}

template <int Dim>
Cells<Dim> cellsOf(const OccupancyMap<Dim>& map) {
    Cells<Dim> cells;
    map.forEachBlock([&](const BlockView<Dim>& block) {
        EXPECT_TRUE(block.known.any()) << "a block without known cells was visited";
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) {
                const bool isNew =
                    cells.emplace(cellInBlock<Dim>(block.key, i), block.values[i]).second;
                EXPECT_TRUE(isNew) << "a cell was visited twice";
            }
    });
    return cells;
}

/// Same known cells, same bits: in the visit and in the queries.
template <int Dim>
::testing::AssertionResult equalsOracle(const OccupancyMap<Dim>& map,
                                        const Cells<Dim>& oracle) {
    const Cells<Dim> cells = cellsOf(map);
    if (cells.size() != oracle.size())
        return ::testing::AssertionFailure()
               << cells.size() << " known cells, oracle has " << oracle.size();
    auto it = cells.begin();
    for (const auto& [cell, value] : oracle) {
        if (it->first != cell) return ::testing::AssertionFailure() << "different known cells";
        if (bitsOf(it->second) != bitsOf(value))
            return ::testing::AssertionFailure() << it->second << " visited, oracle " << value;
        const std::optional<float> query = map.logOdds(cell);
        if (!query || bitsOf(*query) != bitsOf(value))
            return ::testing::AssertionFailure()
                   << (query ? *query : -999.f) << " queried, oracle " << value;
        ++it;
    }
    return ::testing::AssertionSuccess();
}

/// saturation() of every block equals brute force over the oracle.
template <int Dim>
::testing::AssertionResult saturationEquals(const OccupancyMap<Dim>& map,
                                            const Cells<Dim>& oracle, float lowerClamp) {
    std::map<BlockKey<Dim>, BlockSaturation<Dim>> expected;
    for (const auto& [cell, value] : oracle) {
        BlockSaturation<Dim>& block = expected[blockOf<Dim>(cell)];
        if (value == lowerClamp) block.saturatedFree.set(indexInBlock<Dim>(cell));
        block.mayExceedUnknown |= value > 0;
    }
    for (const auto& [key, block] : expected) {
        const BlockSaturation<Dim> got = map.saturation(key, lowerClamp);
        if (got.saturatedFree != block.saturatedFree)
            return ::testing::AssertionFailure() << "masks differ";
        if (block.mayExceedUnknown && !got.mayExceedUnknown)
            return ::testing::AssertionFailure() << "a cell above 0 is kept quiet about";
    }
    return ::testing::AssertionSuccess();
}

/// What the counts of a random block look like.
enum class Fill { none, few, half, allMissed, saturating, hitsOnly };

template <int Dim>
void addRandomBlock(UpdateBatch<Dim>& batch, const BlockKey<Dim>& key, Fill fill,
                    std::mt19937& random) {
    const auto block = batch.addBlock(key);
    const auto draw = [&](int n) { return static_cast<std::uint8_t>(random() % unsigned(n)); };
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        switch (fill) {
            case Fill::none:
                break;
            case Fill::few:
                if (draw(16) == 0)
                    batch.missesOf(block)[i] = static_cast<std::uint8_t>(draw(4) + 1);
                if (draw(40) == 0)
                    batch.hitsOf(block)[i] = static_cast<std::uint8_t>(draw(3) + 1);
                break;
            case Fill::half:
                batch.missesOf(block)[i] = draw(2);
                if (draw(8) == 0) batch.hitsOf(block)[i] = draw(255);
                break;
            case Fill::allMissed:
                batch.missesOf(block)[i] = 1;
                break;
            case Fill::saturating:
                batch.missesOf(block)[i] = static_cast<std::uint8_t>(200 + draw(56));
                break;
            case Fill::hitsOnly:
                if (draw(3) == 0)
                    batch.hitsOf(block)[i] = static_cast<std::uint8_t>(draw(255) + 1);
                break;
        }
    }
}

/// Keys around the origin (negative ones, too), some at the addressable limit.
template <int Dim>
BlockKey<Dim> randomKey(std::mt19937& random) {
    constexpr std::int32_t limit = kCellLimit / kBlockEdge;
    BlockKey<Dim> key;
    for (auto& k : key) {
        const auto r = random() % 16;
        k = r == 0 ? limit - 1 : r == 1 ? -limit : static_cast<std::int32_t>(random() % 4) - 2;
    }
    return key;
}

template <int Dim>
UpdateBatch<Dim> randomBatch(std::mt19937& random, int blocks) {
    UpdateBatch<Dim> batch;
    std::map<BlockKey<Dim>, bool> used;
    for (int b = 0; b < blocks; ++b) {
        const BlockKey<Dim> key = randomKey<Dim>(random);
        if (!used.emplace(key, true).second) continue;
        addRandomBlock<Dim>(batch, key, static_cast<Fill>(random() % 6), random);
    }
    return batch;
}

/// The four storages, for typed tests.
template <typename MapType, int Dimension>
struct StorageCase {
    using Map = MapType;
    static constexpr int Dim = Dimension;
};
using AllStorages = ::testing::Types<StorageCase<BlockGrid<2>, 2>, StorageCase<BlockGrid<3>, 3>,
                                     StorageCase<Quadtree, 2>, StorageCase<Octree, 3>>;

}  // namespace superray::test
