// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file cpu_stopwatch.h

#include <ctime>

namespace superray {

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
