// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A few rays of a scan, as if by chance.

#include <algorithm>
#include <cstdint>
#include <vector>

namespace superray {

/// Numbers of rays, spread over rows and columns of any sensor. Each ray has a place
/// in [0, 1); samples of places that do not overlap have no ray in common.
class RaySample {
 public:
    /// The rays with places in [from, to). \pre 0 <= from < to < 1
    RaySample(double from, double to)
        : from_(static_cast<std::uint32_t>(from * 0x1p32)),
          length_(static_cast<std::uint32_t>((to - from) * 0x1p32)) {}

    /// Those of the first `count` rays, in order. Valid until the next call.
    const std::vector<std::uint32_t>& of(std::size_t count) {
        constexpr std::uint32_t kFactor = 0x9E3779B1;
        while (!sample_.empty() && sample_.back() >= count) sample_.pop_back();
        for (next_ = std::min(next_, count); next_ < count; ++next_) {
            const auto ray = static_cast<std::uint32_t>(next_);
            if (ray * kFactor - from_ < length_) sample_.push_back(ray);
        }
        return sample_;
    }

 private:
    std::uint32_t from_, length_;
    std::vector<std::uint32_t> sample_;
    std::size_t next_ = 0;  // ray to decide about next
};

}  // namespace superray
