// SPDX-License-Identifier: BSD-3-Clause
// The contract of OccupancyMap, checked on every storage.

#include "storage/storage_test_tools.h"

#include <future>
#include <limits>
#include <stdexcept>
#include <typeinfo>

namespace superray::test {
namespace {

template <typename Case>
class OccupancyMapContract : public ::testing::Test {
 protected:
    CellGeometry<Case::Dim> geometry{0.1};
    typename Case::Map map{geometry};
    SensorModel model;
    std::mt19937 random{20190415};
    Cells<Case::Dim> oracle;

    void applyToBoth(const UpdateBatch<Case::Dim>& batch, UpdatePolicy policy) {
        map.apply(batch, model, policy);
        applyToOracle(oracle, batch, model, policy);
    }
    void applyRandomScans(int scans, UpdatePolicy policy = UpdatePolicy::everyRay) {
        for (int s = 0; s < scans; ++s) applyToBoth(randomBatch<Case::Dim>(random, 12), policy);
    }
    Cell<Case::Dim> cell(std::int32_t x, std::int32_t y, std::int32_t z = 0) const {
        Cell<Case::Dim> c{};
        c[0] = x;
        c[1] = y;
        if constexpr (Case::Dim == 3) c[2] = z;
        return c;
    }
};
TYPED_TEST_SUITE(OccupancyMapContract, AllStorages);

TYPED_TEST(OccupancyMapContract, FreshMapIsEmpty) {
    EXPECT_TRUE(this->map.empty());
    EXPECT_TRUE(cellsOf<TypeParam::Dim>(this->map).empty());
    EXPECT_FALSE(this->map.logOdds(this->cell(0, 0)).has_value());
    EXPECT_FALSE(this->map.saturation({}, this->model.min()).saturatedFree.any());
    EXPECT_EQ(summarize(this->map, this->model).known, 0u);
}

TYPED_TEST(OccupancyMapContract, ApplyEqualsOracleForAllPolicies) {
    constexpr int Dim = TypeParam::Dim;
    for (const auto policy : kUpdatePolicies) {
        std::uint64_t touched = 0, atMin = 0, atMax = 0;
        this->map.clear();
        this->oracle.clear();
        for (int scan = 0; scan < 60; ++scan) {
            const auto batch = randomBatch<Dim>(this->random, 12);
            for (std::size_t b = 0; b < batch.blockCount(); ++b)
                touched += static_cast<std::uint64_t>(batch.touched(b).count());
            this->applyToBoth(batch, policy);
            if (scan % 10 == 9) {
                ASSERT_TRUE(equalsOracle<Dim>(this->map, this->oracle)) << "scan " << scan;
            }
            ASSERT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()))
                << "scan " << scan;
        }
        UpdateBatch<Dim> hits;  // enough of the same to reach the upper clamp
        addRandomBlock<Dim>(hits, {}, Fill::hitsOnly, this->random);
        addRandomBlock<Dim>(hits, {1}, Fill::hitsOnly, this->random);
        addRandomBlock<Dim>(hits, {-1}, Fill::hitsOnly, this->random);
        for (int scan = 0; scan < 8; ++scan) this->applyToBoth(hits, policy);
        ASSERT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
        ASSERT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
        for (const auto& [cell, value] : this->oracle) {
            atMin += value == this->model.min();
            atMax += value == this->model.max();
        }
        EXPECT_GT(touched, 10000u);
        EXPECT_GT(atMin, 50u);
        EXPECT_GT(atMax, 50u);
    }
}

TYPED_TEST(OccupancyMapContract, ChangedSensorModelIsFollowed) {
    constexpr int Dim = TypeParam::Dim;
    this->applyRandomScans(10);
    SensorProbabilities p;
    p.clampMin = 0.3;
    p.clampMax = 0.8;
    p.probHit = 0.6;
    const float firstClamp = this->model.min();
    this->model = SensorModel(p);
    this->applyRandomScans(10);
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
    // Bits for the clamp of the model, of an earlier model, and of none.
    for (const float clamp : {this->model.min(), firstClamp, this->model.min(), -77.0f})
        EXPECT_TRUE(saturationEquals<Dim>(this->map, this->oracle, clamp)) << clamp;
    this->applyRandomScans(5);
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
    EXPECT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
}

// The bits for a new clamp are built on the first question: by one of the readers.
TYPED_TEST(OccupancyMapContract, ConcurrentReadersAgree) {
    constexpr int Dim = TypeParam::Dim;
    this->applyRandomScans(10);
    const OccupancyMap<Dim>& shared = this->map;
    const Cells<Dim>& cells = this->oracle;
    const float clamp = this->model.max();  // not the one of the last apply()
    std::array<std::future<bool>, 4> readers;
    for (auto& reader : readers)
        reader = std::async(std::launch::async, [&] {
            return bool(saturationEquals<Dim>(shared, cells, clamp)) &&
                   bool(equalsOracle<Dim>(shared, cells));
        });
    for (auto& reader : readers) EXPECT_TRUE(reader.get());
}

TYPED_TEST(OccupancyMapContract, BlockWithoutTouchedCellsLeavesNoTrace) {
    constexpr int Dim = TypeParam::Dim;
    UpdateBatch<Dim> batch;
    const auto block = batch.addBlock({});
    batch.hitsOf(block);
    this->map.apply(batch, this->model, UpdatePolicy::everyRay);
    EXPECT_TRUE(this->map.empty());
    EXPECT_TRUE(cellsOf<Dim>(this->map).empty());
}

TYPED_TEST(OccupancyMapContract, ExactCountsEqualBatch) {
    constexpr int Dim = TypeParam::Dim;
    const std::unique_ptr<OccupancyMap<Dim>> other = this->map.emptyLike(this->geometry);
    for (int scan = 0; scan < 10; ++scan) {
        const auto batch = randomBatch<Dim>(this->random, 12);
        CellCountMap<Dim> counts;
        for (std::size_t b = 0; b < batch.blockCount(); ++b)
            for (int i = 0; i < kBlockCells<Dim>; ++i)
                counts[cellInBlock<Dim>(batch.key(b), i)] = {
                    batch.misses(b)[i], batch.hits(b) ? batch.hits(b)[i] : 0u};
        this->applyToBoth(batch, UpdatePolicy::everyRay);
        other->apply(counts, this->model, UpdatePolicy::everyRay);
    }
    EXPECT_TRUE(equalsOracle<Dim>(*other, this->oracle));
    EXPECT_TRUE(saturationEquals<Dim>(*other, this->oracle, this->model.min()));
    EXPECT_EQ(contentDigest(this->map), contentDigest(*other));
}

TYPED_TEST(OccupancyMapContract, SetLogOddsAndApplyMix) {
    constexpr int Dim = TypeParam::Dim;
    const float values[] = {this->model.min(), this->model.max(), 0.0f, -9.5f, 7.25f};
    int written = 0;
    for (int round = 0; round < 20; ++round) {
        this->applyRandomScans(1);
        for (int i = 0; i < 200; ++i, ++written) {
            const auto key = randomKey<Dim>(this->random);
            const auto c = cellInBlock<Dim>(
                key, static_cast<int>(this->random() % unsigned(kBlockCells<Dim>)));
            const float value = values[this->random() % 5];
            this->map.setLogOdds(c, value);
            this->oracle[c] = value;
        }
    }
    EXPECT_EQ(written, 4000);
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
    EXPECT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
}

TYPED_TEST(OccupancyMapContract, CellsAllOverTheAddressableRange) {
    constexpr int Dim = TypeParam::Dim;
    std::uniform_int_distribution<std::int32_t> anywhere(-kCellLimit, kCellLimit - 1);
    for (int i = 0; i < 20000; ++i) {
        Cell<Dim> c;
        for (auto& v : c) v = anywhere(this->random);
        this->oracle[c] = i % 3 ? this->model.min() : float(i);
        this->map.setLogOdds(c, this->oracle[c]);
    }
    EXPECT_GT(this->oracle.size(), 19000u);
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
    EXPECT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
}

TYPED_TEST(OccupancyMapContract, SetBlockChangesKnownCellsOnly) {
    constexpr int Dim = TypeParam::Dim;
    this->applyRandomScans(10);
    for (int round = 0; round < 50; ++round) {
        std::array<float, kBlockCells<Dim>> values;
        BlockView<Dim> view{randomKey<Dim>(this->random), values.data(), {}};
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (round % 5 != 0 && this->random() % 2) {
                values[i] = std::numeric_limits<float>::quiet_NaN();  // must not be read
                continue;
            }
            view.known.set(i);
            values[i] = round % 2 ? this->model.min() : float(this->random() % 3);
            this->oracle[cellInBlock<Dim>(view.key, i)] = values[i];
        }
        this->map.setBlock(view);
    }
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
    EXPECT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
}

TYPED_TEST(OccupancyMapContract, VisitBlockEqualsForEachBlock) {
    constexpr int Dim = TypeParam::Dim;
    UpdateBatch<Dim> uniform;  // a block that a tree prunes
    addRandomBlock<Dim>(uniform, this->cell(77, 78), Fill::hitsOnly, this->random);
    for (int scan = 0; scan < 9; ++scan) this->applyToBoth(uniform, UpdatePolicy::everyRay);
    this->applyRandomScans(20);
    std::size_t blocks = 0, cells = 0;
    this->map.forEachBlock([&](const BlockView<Dim>& all) {
        ++blocks;
        EXPECT_TRUE(this->map.visitBlock(all.key, [&](const BlockView<Dim>& one) {
            EXPECT_EQ(one.key, all.key);
            EXPECT_EQ(one.known, all.known);
            for (int i = 0; i < kBlockCells<Dim>; ++i) {
                if (!one.known.test(i)) continue;
                ++cells;
                EXPECT_EQ(one.values[i], all.values[i]);
            }
        }));
    });
    EXPECT_GT(blocks, 20u);
    EXPECT_EQ(cells, this->oracle.size());
    for (const auto& absent : {this->cell(-900, 3), this->cell(kCellLimit, 0)})
        EXPECT_FALSE(this->map.visitBlock(absent, [](const auto&) { FAIL(); }));
}

TYPED_TEST(OccupancyMapContract, UniformBlockSplitsAndMergesAgain) {
    constexpr int Dim = TypeParam::Dim;
    UpdateBatch<Dim> misses, hits;
    addRandomBlock<Dim>(misses, {}, Fill::saturating, this->random);
    addRandomBlock<Dim>(hits, {}, Fill::few, this->random);
    std::size_t uniformBytes = 0;
    for (int round = 0; round < 150; ++round) {
        this->applyToBoth(misses, UpdatePolicy::everyRay);
        ASSERT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
        ASSERT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
        if (round == 1) uniformBytes = this->map.memoryBytes();
        if (round > 1) {
            EXPECT_EQ(this->map.memoryBytes(), uniformBytes) << "memory grows";
        }
        this->applyToBoth(hits, UpdatePolicy::everyRay);
        ASSERT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
        ASSERT_TRUE(saturationEquals<Dim>(this->map, this->oracle, this->model.min()));
    }
}

TYPED_TEST(OccupancyMapContract, SaturatedBlocksTakeLittleMemory) {
    constexpr int Dim = TypeParam::Dim;
    constexpr std::int32_t edge = Dim == 3 ? 16 : 64;
    std::size_t blocks = 0;
    UpdateBatch<Dim> batch;
    for (int i = 0; i < 4096; ++i, ++blocks) {
        BlockKey<Dim> key;
        for (int a = 0, rest = i; a < Dim; ++a, rest /= edge) key[a] = rest % edge - edge / 2;
        addRandomBlock<Dim>(batch, key, Fill::saturating, this->random);
    }
    ASSERT_EQ(blocks, 4096u);
    this->applyToBoth(batch, UpdatePolicy::everyRay);
    EXPECT_LT(this->map.memoryBytes(), 32 * blocks + 100000) << "values are stored per cell";
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
}

TYPED_TEST(OccupancyMapContract, AddressableLimits) {
    constexpr int Dim = TypeParam::Dim;
    const auto low = this->cell(-kCellLimit, 0), high = this->cell(kCellLimit - 1, 0);
    this->map.setLogOdds(low, 1.0f);
    this->map.setLogOdds(high, 2.0f);
    EXPECT_EQ(this->map.logOdds(low), 1.0f);
    EXPECT_EQ(this->map.logOdds(high), 2.0f);
    const std::string digest = contentDigest(this->map);
    for (const auto& c : {this->cell(kCellLimit, 0), this->cell(0, -kCellLimit - 1),
                          this->cell(std::numeric_limits<std::int32_t>::max(), 0)}) {
        EXPECT_THROW(this->map.setLogOdds(c, 1.0f), std::out_of_range);
        EXPECT_FALSE(this->map.logOdds(c).has_value());
        EXPECT_FALSE(this->map.saturation(blockOf<Dim>(c), -2.0f).saturatedFree.any());
    }
    UpdateBatch<Dim> batch;
    addRandomBlock<Dim>(batch, {}, Fill::half, this->random);
    BlockKey<Dim> outside{};
    outside[Dim - 1] = kCellLimit / kBlockEdge;
    addRandomBlock<Dim>(batch, outside, Fill::half, this->random);
    EXPECT_THROW(this->map.apply(batch, this->model, UpdatePolicy::everyRay),
                 std::out_of_range);
    EXPECT_EQ(contentDigest(this->map), digest) << "a refused batch left a trace";
}

TYPED_TEST(OccupancyMapContract, ValuesMustBeFinite) {
    constexpr int Dim = TypeParam::Dim;
    using Limits = std::numeric_limits<float>;
    for (const float bad : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
        EXPECT_THROW(this->map.setLogOdds(this->cell(0, 0), bad), std::invalid_argument);
        std::array<float, kBlockCells<Dim>> values{};
        values[5] = bad;
        EXPECT_THROW(this->map.setBlock({{},
                                         values.data(),
                                         [] {
                                             BlockMask<Dim> m;
                                             m.set(4), m.set(5);
                                             return m;
                                         }()}),
                     std::invalid_argument);
    }
    EXPECT_TRUE(this->map.empty());
    this->map.setLogOdds(this->cell(0, 0), -0.0f);
    EXPECT_EQ(bitsOf(*this->map.logOdds(this->cell(0, 0))), 0u) << "-0 is stored as +0";
}

TYPED_TEST(OccupancyMapContract, CloneIsIndependent) {
    constexpr int Dim = TypeParam::Dim;
    this->applyRandomScans(10);
    const std::unique_ptr<OccupancyMap<Dim>> copy = this->map.clone();
    const Cells<Dim> before = this->oracle;
    this->applyRandomScans(10);
    EXPECT_TRUE(equalsOracle<Dim>(*copy, before));
    EXPECT_TRUE(saturationEquals<Dim>(*copy, before, this->model.min()));
    const Cells<Dim> original = this->oracle;
    copy->apply(randomBatch<Dim>(this->random, 12), this->model, UpdatePolicy::everyRay);
    copy->setLogOdds(this->cell(1, 1), 2.5f);
    copy->clear();
    EXPECT_TRUE(copy->empty());
    EXPECT_TRUE(equalsOracle<Dim>(this->map, original));
    EXPECT_TRUE(saturationEquals<Dim>(this->map, original, this->model.min()));
}

TYPED_TEST(OccupancyMapContract, ClearForgetsEverything) {
    constexpr int Dim = TypeParam::Dim;
    const std::string emptyDigest = contentDigest(this->map);
    this->applyRandomScans(5);
    EXPECT_FALSE(this->map.empty());
    this->map.clear();
    this->oracle.clear();
    EXPECT_TRUE(this->map.empty());
    EXPECT_EQ(contentDigest(this->map), emptyDigest);
    EXPECT_FALSE(this->map.saturation({}, this->model.min()).saturatedFree.any());
    this->applyRandomScans(5);
    EXPECT_TRUE(equalsOracle<Dim>(this->map, this->oracle));
}

TYPED_TEST(OccupancyMapContract, SwapContents) {
    constexpr int Dim = TypeParam::Dim;
    this->applyRandomScans(5);
    typename TypeParam::Map other(this->geometry);
    other.setLogOdds(this->cell(3, 4), 1.5f);
    this->map.swapContents(other);
    EXPECT_TRUE(equalsOracle<Dim>(other, this->oracle));
    EXPECT_TRUE(saturationEquals<Dim>(other, this->oracle, this->model.min()));
    EXPECT_TRUE(equalsOracle<Dim>(this->map, {{this->cell(3, 4), 1.5f}}));
    EXPECT_TRUE(saturationEquals<Dim>(this->map, {{this->cell(3, 4), 1.5f}}, 1.5f));
    typename TypeParam::Map coarser(CellGeometry<Dim>(0.2));
    EXPECT_THROW(this->map.swapContents(coarser), std::invalid_argument);
}

TYPED_TEST(OccupancyMapContract, SummaryEqualsBruteForce) {
    constexpr int Dim = TypeParam::Dim;
    this->applyRandomScans(10);
    MapSummary<Dim> expected;
    for (const auto& [c, value] : this->oracle) {
        if (expected.known++ == 0) expected.lowest = expected.highest = c;
        ++(value >= this->model.occupied() ? expected.occupied : expected.free);
        for (int a = 0; a < Dim; ++a) {
            expected.lowest[a] = std::min(expected.lowest[a], c[a]);
            expected.highest[a] = std::max(expected.highest[a], c[a]);
        }
    }
    const auto s = summarize(this->map, this->model);
    EXPECT_EQ(s.known, expected.known);
    EXPECT_EQ(s.occupied, expected.occupied);
    EXPECT_EQ(s.free, expected.free);
    EXPECT_EQ(s.lowest, expected.lowest);
    EXPECT_EQ(s.highest, expected.highest);
    EXPECT_GT(s.occupied, 100u);
    EXPECT_GT(s.free, 100u);
}

TYPED_TEST(OccupancyMapContract, SummaryCountsWholeBlocks) {
    constexpr int Dim = TypeParam::Dim;
    std::vector<float> values(kBlockCells<Dim>, -1.0f);
    BlockMask<Dim> all;
    for (auto& word : all.words) word = ~std::uint64_t{0};
    BlockKey<Dim> key{};
    key.fill(-2);
    this->map.setBlock({key, values.data(), all});
    for (int i = 0; i < kBlockCells<Dim>; i += 3) values[static_cast<std::size_t>(i)] = 1;
    const auto occupied = static_cast<std::uint64_t>((kBlockCells<Dim> + 2) / 3);
    key.fill(1);
    this->map.setBlock({key, values.data(), all});
    const auto s = summarize(this->map, this->model);
    EXPECT_EQ(s.known, 2u * kBlockCells<Dim>);
    EXPECT_EQ(s.occupied, occupied);
    EXPECT_EQ(s.free, s.known - occupied);
    for (int a = 0; a < Dim; ++a) {
        EXPECT_EQ(s.lowest[a], -2 * kBlockEdge);
        EXPECT_EQ(s.highest[a], 2 * kBlockEdge - 1);
    }
}

TYPED_TEST(OccupancyMapContract, MemoryGrowsWithContents) {
    const std::size_t before = this->map.memoryBytes();
    this->applyRandomScans(10);
    EXPECT_GT(this->map.memoryBytes(), before + this->oracle.size());
}

TYPED_TEST(OccupancyMapContract, ReservedMemoryIsUsedBeforeOther) {
    constexpr std::size_t kReserved = 16u << 20;
    this->map.reserve(kReserved);
    const std::size_t reserved = this->map.memoryBytes();
    EXPECT_GT(reserved, kReserved * 9 / 10);
    EXPECT_LT(reserved, kReserved * 11 / 10);
    this->map.reserve(kReserved);
    EXPECT_EQ(this->map.memoryBytes(), reserved) << "that much is at hand already";
    EXPECT_TRUE(this->map.empty());

    this->applyRandomScans(10);
    EXPECT_TRUE(equalsOracle<TypeParam::Dim>(this->map, this->oracle));
    EXPECT_LT(this->map.memoryBytes(), reserved * 21 / 20) << "only hash tables grow";
    this->map.reserve(kReserved);
    EXPECT_TRUE(equalsOracle<TypeParam::Dim>(this->map, this->oracle));
    EXPECT_LT(this->map.clone()->memoryBytes() + kReserved * 9 / 10, this->map.memoryBytes())
        << "a clone does not get it";
    this->map.clear();
    EXPECT_LT(this->map.memoryBytes(), kReserved / 10);
}

TEST(OccupancyMap, SwapRefusesAnotherType) {
    BlockGrid<3> grid{CellGeometry<3>(0.1)};
    Octree tree{CellGeometry<3>(0.1)};
    EXPECT_THROW(grid.swapContents(tree), std::bad_cast);
    EXPECT_THROW(tree.swapContents(grid), std::bad_cast);
}

}  // namespace
}  // namespace superray::test
