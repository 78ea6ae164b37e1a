#pragma once
/// \file progress_meter.h
/// Progress for people: rate, time left, and numbers that can be read.

#include <superray/eval/map_build.h>

#include <cstdint>
#include <iosfwd>
#include <string>

namespace superray {

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
