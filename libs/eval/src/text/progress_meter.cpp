// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/progress_meter.h>

#include <cmath>
#include <cstdio>
#include <ostream>

namespace superray {
namespace {

template <class... Args>
std::string format(const char* pattern, Args... args) {
    char text[96];
    std::snprintf(text, sizeof text, pattern, args...);
    return text;
}

}  // namespace

std::string formatCount(std::uint64_t number) {
    std::string text = std::to_string(number);
    for (auto i = static_cast<std::ptrdiff_t>(text.size()) - 3; i > 0; i -= 3)
        text.insert(static_cast<std::size_t>(i), ",");
    return text;
}

std::string formatSeconds(double seconds) {
    if (!(seconds >= 0)) seconds = 0;
    if (seconds < 9.995) return format("%.2f s", seconds);
    if (seconds < 119.5) return format("%.0f s", seconds);
    const double minutes = std::floor(std::round(seconds) / 60);
    if (minutes < 120)
        return format("%.0f min %02.0f s", minutes, std::round(seconds) - 60 * minutes);
    return format("%.0f h %02.0f min", std::floor(minutes / 60), std::fmod(minutes, 60));
}

std::string formatBytes(std::uint64_t bytes) {
    if (bytes < 1000) return std::to_string(bytes) + " B";
    double value = static_cast<double>(bytes);
    const char* unit = "B";
    for (const char* larger : {"kB", "MB", "GB", "TB"}) {
        if (value < 999.95) break;
        value /= 1000;
        unit = larger;
    }
    return format("%.1f %s", value, unit);
}

std::string progressLine(const BuildProgress& p) {
    const std::string done =
        std::to_string(p.scans) + "/" + std::to_string(p.totalScans) + " scans";
    if (p.seconds <= 0 || p.scans == 0) return done;
    const double rate = static_cast<double>(p.scans) / p.seconds;
    const double left =
        static_cast<double>(p.totalScans - std::min(p.scans, p.totalScans)) / rate;
    return done +
           format("  %.1f scans/s  %.2f Mrays/s  ", rate,
                  static_cast<double>(p.rays) / p.seconds * 1e-6) +
           formatSeconds(left) + " left";
}

void ProgressMeter::update(const BuildProgress& progress) {
    const double period = style_ == Style::terminal ? 0.1 : 10.0;  // s
    const bool last = progress.scans == progress.totalScans;
    if (progress.seconds - lastShown_ < period && !(last && style_ == Style::terminal)) return;
    lastShown_ = progress.seconds;
    std::string line = progressLine(progress);
    if (style_ == Style::log) {
        out_ << line << std::endl;
        return;
    }
    const std::size_t length = line.size();
    if (length < lineLength_) line.append(lineLength_ - length, ' ');
    lineLength_ = length;
    out_ << '\r' << line << std::flush;
}

ProgressMeter::~ProgressMeter() {
    if (lineLength_ > 0) out_ << std::endl;
}

}  // namespace superray
