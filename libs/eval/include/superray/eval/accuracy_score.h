// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file accuracy_score.h
/// How well probabilities of a map agree with points of which the truth is known.

#include <cstdint>
#include <optional>
#include <vector>

namespace superray {

/// What a map says at a point of which the truth is known.
struct ScoredPoint {
    bool occupied = false;              ///< the truth
    std::optional<double> probability;  ///< of being occupied; nothing where unknown
    std::uint64_t cell = 0;             ///< any number that is the cell's own
};

/// Counts of the points of one kind, occupied or free.
struct ClassScore {
    std::uint64_t tested = 0;
    std::uint64_t right = 0;        ///< p > 0.7 if occupied, p < 0.3 if free (the paper's)
    std::uint64_t rightAtHalf = 0;  ///< p > 0.5 if occupied, p < 0.5 if free
    std::uint64_t unknown = 0;      ///< always wrong

    /// Counts one point more.
    void add(bool occupied, std::optional<double> probability);
    ClassScore& operator+=(const ClassScore& other);
    double share() const { return shareOf(right); }  ///< 0 if none was tested
    double shareAtHalf() const { return shareOf(rightAtHalf); }

 private:
    double shareOf(std::uint64_t count) const {
        return tested == 0 ? 0 : static_cast<double>(count) / static_cast<double>(tested);
    }
};

struct AccuracyScore {
    ClassScore occupied, free;
    /// Chance that an occupied point has a larger probability than a free one,
    /// ties counted half, unknown taken as 0.5. Nothing unless there are both.
    std::optional<double> auc;
    /// Points that agree with the more frequent truth of their cell: no map of
    /// these cells has more right.
    std::uint64_t ceiling = 0;

    ClassScore all() const;
};

AccuracyScore scoreOf(const std::vector<ScoredPoint>& points);

}  // namespace superray
