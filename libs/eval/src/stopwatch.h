#pragma once
/// \file stopwatch.h

#include <chrono>
#include <ctime>

namespace superray {

/// Time since construction.
class Stopwatch {
 public:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

 private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Processor time of this process, all threads, since construction.
class CpuStopwatch {
 public:
    double seconds() const { return now() - start_; }

 private:
    static double now() {
        timespec t{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }
    double start_ = now();
};

}  // namespace superray
