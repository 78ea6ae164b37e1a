// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file clock_time.h
/// Stamps of recordings as times of MRPT.

#include <mrpt/core/Clock.h>

#include <cstdint>

namespace superray {

/// The time of a stamp since 1970, to 100 ns. mrpt::Clock::fromDouble() is no help: seconds
/// with a fraction do not fit a double.
inline mrpt::Clock::time_point timeOfStamp(std::int64_t seconds, std::int64_t nanoseconds) {
    constexpr std::int64_t kTicks = 10'000'000;  // of mrpt::Clock in a second
    constexpr std::int64_t kNanosecondsPerTick = 100;
    constexpr std::int64_t k1970 = 11'644'473'600;  // its time then [s]
    return mrpt::Clock::time_point(
        mrpt::Clock::duration((k1970 + seconds) * kTicks + nanoseconds / kNanosecondsPerTick));
}

}  // namespace superray
