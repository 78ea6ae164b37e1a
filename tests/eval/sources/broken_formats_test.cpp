// SPDX-License-Identifier: BSD-3-Clause
// Files of every format, cut anywhere or with other bytes: never a crash, never mapped
// silently as if whole.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>

#include <array>
#include <cstdio>
#include <deque>
#include <optional>
#include <random>

#include "eval/sources/breakable_samples.h"
#include "eval/sources/broken_bytes.h"
#include "eval/sources/limited_process.h"

namespace superray {
namespace {

using namespace test;

class BrokenFormats : public testing::TestWithParam<Breakable> {
 protected:
    BrokenFormats() : copy_(GetParam()), expected_(copy_.buildWith(copy_.whole())) {}

    /// Nothing if it is refused, in one line.
    std::optional<Built> buildWith(const std::string& bytes) {
        try {
            return copy_.buildWith(bytes);
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
            return std::nullopt;
        }
    }

    BreakableCopy copy_;
    Built expected_;
};

/// Never a crash, never a hang; if it is read, then as the whole one (the file ended in
/// bytes that do not matter), or without what was left out.
TEST_P(BrokenFormats, truncatedAnywhere) {
    int refused = 0;
    const std::string& whole = copy_.whole();
    for (std::size_t i = 0; i < 100; ++i) {
        const std::size_t length = whole.size() * i / 100;
        const auto built = buildWith(whole.substr(0, length));
        refused += !built;
        if (!built || built->digest == expected_.digest) continue;
        const bool isTold =
            copy_.mayLookWhole(length) ||
            (GetParam().cuts == Cuts::seenInCounts && built->scans < expected_.scans);
        EXPECT_TRUE(isTold) << "silently, at " << length;
    }
    EXPECT_GT(refused, 15);  // binary PCD is filled up to 4 kB
}

TEST_P(BrokenFormats, randomBytes) {
    std::mt19937 random(7);
    int refused = 0;
    const std::string& whole = copy_.whole();
    for (int i = 0; i < 100; ++i) {
        auto broken = whole;
        for (int k = i % 2 == 0 ? 100 : 1; k > 0; --k)
            broken[random() % broken.size()] = static_cast<char>(random());
        refused += !buildWith(broken);
    }
    const bool hasRules = GetParam().cuts != Cuts::seenBut16Bytes;  // any bytes are points
    if (hasRules) {
        EXPECT_GT(refused, 25);
    }
}

INSTANTIATE_TEST_SUITE_P(Samples, BrokenFormats, testing::ValuesIn(breakables()));

/// Exit codes of the process that maps a broken file.
enum : int { kAsWhole = 0, kRefused = 1, kFewerScans = 2, kOtherMap = 3, kOtherError = 4 };

int outcomeOf(const BreakableCopy& copy, const std::string& bytes, const Built& whole) {
    try {
        const Built built = copy.buildWith(bytes);
        if (built.digest == whole.digest) return kAsWhole;
        return built.scans < whole.scans ? kFewerScans : kOtherMap;
    } catch (const InputError&) {
        return kRefused;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return kOtherError;
    }
}

struct BrokenFile {
    bool isCut = false;
    std::string bytes;
};

/// What is wrong with what became of a broken file; empty if nothing is.
std::string harmOf(const LimitedRun& run, const BrokenFile& file, const BreakableCopy& copy) {
    if (!run.harm.empty()) return run.harm;
    if (run.result == kOtherError) return "an unexpected error";
    if (file.isCut && run.result == kOtherMap && !copy.mayLookWhole(file.bytes.size()))
        return "another map of as many scans, from " + std::to_string(file.bytes.size()) +
               " bytes";
    return {};
}

// Half of them are cut, half are changed; with limits of time and memory.
TEST(ManyBrokenFormats, DoNoHarm) {
    const auto [count, seed] = orOfEnvironment({500, 19});
    std::deque<BreakableCopy> samples;
    std::vector<Built> whole;
    for (const Breakable& b : breakables()) {
        samples.emplace_back(b);
        whole.push_back(samples.back().buildWith(samples.back().whole()));
    }
    std::mt19937 random(seed);
    std::array<int, 5> outcomes{};
    for (int done = 0; done < count;) {
        std::vector<BrokenFile> files(samples.size());
        for (std::size_t n = 0; n < files.size(); ++n) {
            const std::string& bytes = samples[n].whole();
            files[n] = {random() % 2 == 0, {}};
            files[n].bytes = files[n].isCut ? bytes.substr(0, random() % bytes.size())
                                            : mutated(bytes, random);
        }
        const auto runs = runLimited(files.size(), [&](std::size_t n) {
            return outcomeOf(samples[n], files[n].bytes, whole[n]);
        });
        for (std::size_t n = 0; n < files.size(); ++n, ++done) {
            const std::string harm = harmOf(runs[n], files[n], samples[n]);
            if (!harm.empty())
                ADD_FAILURE() << harm << ": " << testing::PrintToString(breakables()[n])
                              << ", kept in "
                              << keepBroken("format-" + std::to_string(seed) + "-" +
                                                std::to_string(done),
                                            files[n].bytes);
            if (runs[n].result >= 0) ++outcomes.at(static_cast<std::size_t>(runs[n].result));
        }
    }
    EXPECT_GT(outcomes[kRefused], count / 3);
    EXPECT_GT(outcomes[kAsWhole] + outcomes[kOtherMap], count / 50);
    std::printf("%d refused, %d as whole, %d with fewer scans, %d with other values\n",
                outcomes[kRefused], outcomes[kAsWhole], outcomes[kFewerScans],
                outcomes[kOtherMap]);
}

}  // namespace
}  // namespace superray
