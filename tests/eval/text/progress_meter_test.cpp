// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <superray/eval/progress_meter.h>

#include <algorithm>
#include <sstream>

namespace superray {
namespace {

TEST(Formats, counts) {
    EXPECT_EQ(formatCount(0), "0");
    EXPECT_EQ(formatCount(999), "999");
    EXPECT_EQ(formatCount(1000), "1,000");
    EXPECT_EQ(formatCount(12345678), "12,345,678");
}

TEST(Formats, seconds) {
    EXPECT_EQ(formatSeconds(0), "0.00 s");
    EXPECT_EQ(formatSeconds(0.421), "0.42 s");
    EXPECT_EQ(formatSeconds(9.996), "10 s");
    EXPECT_EQ(formatSeconds(119.6), "2 min 00 s");
    EXPECT_EQ(formatSeconds(185), "3 min 05 s");
    EXPECT_EQ(formatSeconds(7800), "2 h 10 min");
    EXPECT_EQ(formatSeconds(-1), "0.00 s");
}

TEST(Formats, bytes) {
    EXPECT_EQ(formatBytes(999), "999 B");
    EXPECT_EQ(formatBytes(3440), "3.4 kB");
    EXPECT_EQ(formatBytes(999960), "1.0 MB");
    EXPECT_EQ(formatBytes(12000000), "12.0 MB");
}

TEST(ProgressLine, tellsRateAndTimeLeft) {
    BuildProgress p;
    p.totalScans = 100;
    EXPECT_EQ(progressLine(p), "0/100 scans");
    p.scans = 25;
    p.rays = 50'000'000;
    p.seconds = 10;
    EXPECT_EQ(progressLine(p), "25/100 scans  2.5 scans/s  5.00 Mrays/s  30 s left");
}

TEST(ProgressMeter, writesALineEveryTenSecondsToALog) {
    std::ostringstream out;
    {
        ProgressMeter meter(out, ProgressMeter::Style::log);
        for (std::uint64_t i = 1; i <= 35; ++i)
            meter.update({i, 35, i, static_cast<double>(i)});
    }
    const std::string text = out.str();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\r'), 0);
}

TEST(ProgressMeter, redrawsOneLineOnATerminal) {
    std::ostringstream out;
    {
        ProgressMeter meter(out, ProgressMeter::Style::terminal);
        for (std::uint64_t i = 1; i <= 100; ++i)
            meter.update({i, 100, i, 0.05 * static_cast<double>(i)});
    }
    const std::string text = out.str();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
    const auto drawn = std::count(text.begin(), text.end(), '\r');
    EXPECT_GE(drawn, 20);
    EXPECT_LE(drawn, 51);
    EXPECT_NE(text.find("100/100 scans"), std::string::npos);
}

}  // namespace
}  // namespace superray
