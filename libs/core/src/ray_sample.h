#pragma once
// A few rays of a scan, as if by chance.

#include <algorithm>
#include <cstdint>
#include <vector>

namespace superray {

/// Numbers of rays, spread over rows and columns of any sensor.
class RaySample {
 public:
    static constexpr double kShare = 4.0 / 37;

    /// Those of the first `count` rays, in order. Valid until the next call.
    const std::vector<std::uint32_t>& of(std::size_t count) {
        constexpr std::uint32_t kFactor = 0x9E3779B1;
        constexpr auto kLimit = static_cast<std::uint32_t>(kShare * 0x1p32);
        while (!sample_.empty() && sample_.back() >= count) sample_.pop_back();
        for (next_ = std::min(next_, count); next_ < count; ++next_) {
            const auto ray = static_cast<std::uint32_t>(next_);
            if (ray * kFactor < kLimit) sample_.push_back(ray);
        }
        return sample_;
    }

 private:
    std::vector<std::uint32_t> sample_;
    std::size_t next_ = 0;  // ray to decide about next
};

}  // namespace superray
