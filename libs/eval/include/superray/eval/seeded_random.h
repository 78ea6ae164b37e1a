// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file seeded_random.h
/// Random numbers that are the same on every machine: the distributions of the
/// standard library are not.

#include <cstdint>
#include <random>

namespace superray {

/// std::mt19937_64 (the standard fixes its numbers) with our own distributions.
class SeededRandom {
 public:
    /// \param stream several independent sequences may share a seed
    explicit SeededRandom(std::uint64_t seed, std::uint64_t stream = 0)
        : engine_(seed * 0x9E3779B97F4A7C15ull + stream * 0xD1B54A32D192ED03ull + 1) {}

    /// In [0, 1), a multiple of 2^-53.
    double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    /// Close to a normal distribution of this sigma, but never beyond
    /// kBellBound * sigma: the sum of four uniform numbers.
    double bell(double sigma) {
        const double sum = uniform() + uniform() + uniform() + uniform() - 2;
        return sum * sigma * kSqrt3;
    }
    static constexpr double kBellBound = 3.4641016151377544;  // 2 sqrt(3)

 private:
    static constexpr double kSqrt3 = 1.7320508075688772;
    std::mt19937_64 engine_;
};

}  // namespace superray
