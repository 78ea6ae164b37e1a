// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/accuracy_score.h>

#include <algorithm>
#include <utility>

namespace superray {
namespace {

constexpr double kOccupied = 0.7, kFree = 0.3, kHalf = 0.5;
/// A single hit makes exactly 0.7, up to the rounding of an engine.
constexpr double kRounding = 1e-6;

/// Visits runs of equal keys: how many occupied and free points each has.
template <class Key, class Visit>
void forEachRun(std::vector<std::pair<Key, bool>>& points, const Visit& visit) {
    std::sort(points.begin(), points.end());
    for (std::size_t i = 0; i < points.size();) {
        const std::size_t first = i;
        std::uint64_t occupied = 0;
        for (; i < points.size() && points[i].first == points[first].first; ++i)
            occupied += points[i].second;
        visit(occupied, i - first - occupied);
    }
}

std::uint64_t ceilingOf(const std::vector<ScoredPoint>& points) {
    std::vector<std::pair<std::uint64_t, bool>> byCell;
    byCell.reserve(points.size());
    for (const ScoredPoint& p : points) byCell.emplace_back(p.cell, p.occupied);
    std::uint64_t ceiling = 0;
    forEachRun(byCell, [&](std::uint64_t occupied, std::uint64_t free) {
        ceiling += std::max(occupied, free);
    });
    return ceiling;
}

/// \pre there are occupied points and free ones
double aucOf(const std::vector<ScoredPoint>& points) {
    std::vector<std::pair<double, bool>> byProbability;
    byProbability.reserve(points.size());
    for (const ScoredPoint& p : points)
        byProbability.emplace_back(p.probability.value_or(kHalf), p.occupied);
    double ordered = 0, freeBelow = 0, occupiedBelow = 0;
    forEachRun(byProbability, [&](std::uint64_t occupiedHere, std::uint64_t freeHere) {
        const auto occupied = static_cast<double>(occupiedHere);
        const auto free = static_cast<double>(freeHere);
        ordered += occupied * (freeBelow + free / 2);
        freeBelow += free;
        occupiedBelow += occupied;
    });
    return ordered / occupiedBelow / freeBelow;
}

}  // namespace

void ClassScore::add(bool occupied, std::optional<double> probability) {
    ++tested;
    if (!probability) {
        ++unknown;
        return;
    }
    const double p = *probability;
    right += occupied ? p > kOccupied + kRounding : p < kFree;
    rightAtHalf += occupied ? p > kHalf : p < kHalf;
}

ClassScore& ClassScore::operator+=(const ClassScore& o) {
    tested += o.tested;
    right += o.right;
    rightAtHalf += o.rightAtHalf;
    unknown += o.unknown;
    return *this;
}

ClassScore AccuracyScore::all() const {
    ClassScore sum = occupied;
    return sum += free;
}

AccuracyScore scoreOf(const std::vector<ScoredPoint>& points) {
    AccuracyScore score;
    for (const ScoredPoint& p : points)
        (p.occupied ? score.occupied : score.free).add(p.occupied, p.probability);
    score.ceiling = ceilingOf(points);
    if (score.occupied.tested > 0 && score.free.tested > 0) score.auc = aucOf(points);
    return score;
}

}  // namespace superray
