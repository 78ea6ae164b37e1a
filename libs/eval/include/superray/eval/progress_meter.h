// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file progress_meter.h
/// Progress for people: rate, time left, and numbers that can be read.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>

namespace superray {

/// How far a build is.
struct BuildProgress {
    std::uint64_t scans = 0, totalScans = 0;
    std::uint64_t rays = 0;  ///< inserted so far
    double seconds = 0;      ///< since the first scan
};

/// Told after each scan: how many of how many are loaded.
using LoadProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// "12,345,678"
std::string formatCount(std::uint64_t number);
/// "0.42 s", "12 s", "3 min 05 s", "2 h 10 min"
std::string formatSeconds(double seconds);
/// "512 B", "3.4 kB", "12.0 MB"
std::string formatBytes(std::uint64_t bytes);

/// "12/100 scans  8.3 scans/s  2.27 Mrays/s  11 s left"
std::string progressLine(const BuildProgress& progress);

/// Shows progress without flooding: on a terminal one line that is redrawn, in
/// a log a line every ten seconds.
class ProgressMeter {
 public:
    enum class Style { terminal, log };
    ProgressMeter(std::ostream& out, Style style) : out_(out), style_(style) {}
    /// Leaves the line that was redrawn.
    ~ProgressMeter();
    ProgressMeter(const ProgressMeter&) = delete;
    ProgressMeter& operator=(const ProgressMeter&) = delete;

    void update(const BuildProgress& progress);

 private:
    std::ostream& out_;
    Style style_;
    double lastShown_ = 0;  // s
    std::size_t lineLength_ = 0;
};

}  // namespace superray
