// SPDX-License-Identifier: BSD-3-Clause
#include "queries/coarse_levels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace superray {
namespace {

/// Sums up known parts: log-odds for the maximum, probabilities for the mean.
class Sum {
 public:
    explicit Sum(LevelRule rule) : rule_(rule) {}

    void add(double value) {
        value_ = count_ == 0                ? value
                 : rule_ == LevelRule::mean ? value_ + value
                                            : std::max(value_, value);
        ++count_;
    }
    std::optional<double> value() const {
        if (count_ == 0) return std::nullopt;
        return rule_ == LevelRule::mean ? value_ / count_ : value_;
    }

 private:
    LevelRule rule_;
    double value_ = 0;
    int count_ = 0;
};

template <int Dim>
using Values = std::unordered_map<Cell<Dim>, double, IndexHash>;

template <int Dim>
Cell<Dim> shifted(Cell<Dim> c, unsigned levels) {
    for (auto& v : c) v >>= levels;
    return c;
}

/// One level up.
template <int Dim>
Values<Dim> coarser(const Values<Dim>& fine, LevelRule rule) {
    std::unordered_map<Cell<Dim>, Sum, IndexHash> sums;
    for (const auto& [cell, value] : fine)
        sums.try_emplace(shifted<Dim>(cell, 1), rule).first->second.add(value);
    Values<Dim> result;
    for (const auto& [cell, sum] : sums) result.emplace(cell, *sum.value());
    return result;
}

/// \param levels of the cube above blocks, <= 13
template <int Dim, class Visit>
void forEachBlockOfCube(const OccupancyMap<Dim>& map, const Cell<Dim>& cube, unsigned levels,
                        const Visit& visit) {
    const std::uint64_t blocks = std::uint64_t{1} << (Dim * levels);
    if (blocks > kCubeBlocks) {
        map.forEachBlock([&](const BlockView<Dim>& block) {
            if (shifted<Dim>(block.key, levels) == cube) visit(block);
        });
        return;
    }
    for (std::uint64_t i = 0; i < blocks; ++i) {
        BlockKey<Dim> key;
        for (std::size_t a = 0; a < Dim; ++a)
            key[a] = cube[a] * (1 << levels) +
                     static_cast<std::int32_t>((i >> (levels * a)) & ((1u << levels) - 1));
        map.visitBlock(key, visit);
    }
}

/// Sums of the cells of a block that are in the cube, at level min(level, 3).
template <int Dim>
Values<Dim> sumUpBlock(const BlockView<Dim>& block, const Cell<Dim>& cube, unsigned level,
                       LevelRule rule) {
    Values<Dim> values;
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        if (!block.known.test(i)) continue;
        const Cell<Dim> c = cellInBlock<Dim>(block.key, i);
        if (shifted<Dim>(c, level) != cube) continue;
        const float v = block.values[i];
        values.emplace(c, rule == LevelRule::mean ? probabilityOf(v) : double{v});
    }
    for (unsigned l = 0; l < std::min<unsigned>(level, kBlockBits); ++l)
        values = coarser<Dim>(values, rule);
    return values;
}

}  // namespace

template <int Dim>
std::optional<float> logOddsAtLevel(const OccupancyMap<Dim>& map, const Cell<Dim>& cell,
                                    unsigned level, LevelRule rule) {
    if (level > kCoarsestLevel)
        throw std::invalid_argument("level " + std::to_string(level) + ": must be at most " +
                                    std::to_string(kCoarsestLevel));
    if (level == 0) return map.logOdds(cell);
    const Cell<Dim> cube = shifted<Dim>(cell, level);
    Values<Dim> values;
    const auto add = [&](const BlockView<Dim>& block) {
        values.merge(sumUpBlock<Dim>(block, cube, level, rule));
    };
    if (level <= kBlockBits) {
        map.visitBlock(blockOf<Dim>(cell), add);
    } else {
        forEachBlockOfCube<Dim>(map, cube, level - kBlockBits, add);
        for (unsigned l = kBlockBits; l < level; ++l) values = coarser<Dim>(values, rule);
    }
    if (values.empty()) return std::nullopt;
    const double value = values.begin()->second;
    return rule == LevelRule::mean ? logOddsOf(value) : static_cast<float>(value);
}

template std::optional<float> logOddsAtLevel(const OccupancyMap<2>&, const Cell<2>&, unsigned,
                                             LevelRule);
template std::optional<float> logOddsAtLevel(const OccupancyMap<3>&, const Cell<3>&, unsigned,
                                             LevelRule);

}  // namespace superray
