#pragma once
/// \file stopwatch.h

#include <chrono>

namespace superray {

/// Seconds since the last lap.
class Stopwatch {
 public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double seconds = std::chrono::duration<double>(now - start_).count();
        start_ = now;
        return seconds;
    }

 private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace superray
