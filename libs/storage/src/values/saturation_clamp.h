// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file saturation_clamp.h
/// The lower clamp that the saturation bits of a storage belong to.

#include <superray/storage/occupancy_map.h>

#include <atomic>
#include <limits>
#include <mutex>
#include <stdexcept>

namespace superray {

/// Bits are kept for one clamp at a time and rebuilt when another is asked for
/// (a map meets a second one only when its sensor model changes). Concurrent
/// readers that use the same clamp are safe: one rebuilds, the others wait.
class SaturationClamp {
 public:
    SaturationClamp() = default;
    SaturationClamp(const SaturationClamp& o) : clamp_(o.clamp_.load()) {}

    /// NaN, which equals no value, until use() was called.
    float value() const { return clamp_.load(std::memory_order_relaxed); }
    bool isAt(float value) const { return value == this->value(); }

    /// Calls rebuild() if the bits belong to another clamp.
    template <typename Rebuild>
    void use(float clamp, Rebuild&& rebuild) {
        if (clamp_.load(std::memory_order_acquire) == clamp) return;
        const std::lock_guard<std::mutex> lock(mutex_);
        if (clamp_.load(std::memory_order_relaxed) == clamp) return;
        rebuild();
        clamp_.store(clamp, std::memory_order_release);
    }

    /// \pre no concurrent readers of either
    void swap(SaturationClamp& o) { clamp_ = o.clamp_.exchange(clamp_); }

 private:
    std::atomic<float> clamp_{std::numeric_limits<float>::quiet_NaN()};
    std::mutex mutex_;
};

template <int Dim>
void requireSameResolution(const OccupancyMap<Dim>& a, const OccupancyMap<Dim>& b) {
    if (a.geometry().resolution() != b.geometry().resolution())
        throw std::invalid_argument(
            "maps of different resolution: " + metresText(a.geometry().resolution()) + " and " +
            metresText(b.geometry().resolution()));
}

}  // namespace superray
