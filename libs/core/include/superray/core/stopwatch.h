// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file stopwatch.h
/// Elapsed time.

#include <chrono>

namespace superray {

class Stopwatch {
 public:
    /// Seconds since construction or the last lap.
    double seconds() const {
        return std::chrono::duration<double>(Clock::now() - start_).count();
    }
    /// The same, and begins another lap.
    double lap() {
        const auto now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - start_).count();
        start_ = now;
        return seconds;
    }

 private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

}  // namespace superray
