// SPDX-License-Identifier: BSD-3-Clause
// ROS recordings cut anywhere or with other bytes: never a crash, never mapped silently as if
// whole.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>

#include <filesystem>
#include <map>
#include <optional>
#include <ostream>
#include <random>

#include "eval/sources/ros_samples.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using namespace test;

/// Whether bytes that changed can be seen.
enum class Changes {
    always,    ///< by check sums
    sometimes  ///< only where they break a rule
};

struct Sample {
    const char *recording, *file;
    Changes changes;
};

void PrintTo(const Sample& s, std::ostream* out) {
    *out << s.recording << s.file;
}

class BrokenRos : public testing::TestWithParam<Sample> {
 protected:
    BrokenRos() {
        const std::string name = GetParam().recording;
        path_ = folder_ / fs::path(name).filename().string();
        fs::copy(sample(name), path_, fs::copy_options::recursive);
        broken_ = path_ + GetParam().file;
        whole_ = readWholeFile(broken_);
        options_ = rosOptions("/points", "tf map");
        expected_ = build(path_, options_);
    }

    /// Nothing if it is refused, in one line.
    std::optional<Built> buildWith(const std::string& bytes, Truncation truncation) {
        std::ofstream(broken_, std::ios::binary) << bytes;
        ScanSourceOptions options = options_;
        options.truncation = truncation;
        try {
            return build(path_, options);
        } catch (const InputError& e) {
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
            return std::nullopt;
        }
    }

    /// The map of the first scans.
    std::string digestOf(std::uint64_t scans) {
        auto& digest = digests_[scans];
        if (digest.empty()) {
            std::ofstream(broken_, std::ios::binary) << whole_;
            ScanSourceOptions options = options_;
            options.maxScans = scans;
            digest = build(path_, options).digest;
        }
        return digest;
    }

    TempFolder folder_;
    std::string path_, broken_, whole_;
    ScanSourceOptions options_;
    Built expected_;
    std::map<std::uint64_t, std::string> digests_;
};

TEST_P(BrokenRos, truncatedAnywhere) {
    int accepted = 0, refused = 0;
    for (std::size_t i = 0; i < 100; ++i) {
        const auto cut = whole_.substr(0, whole_.size() * i / 100);
        const auto built = buildWith(cut, Truncation::error);
        // Behind its list of files nothing of metadata.yaml matters.
        EXPECT_TRUE(!built || built->digest == expected_.digest)
            << "silently, at " << cut.size();
        refused += !built;
        // What is before the break, and nothing else.
        const auto before = buildWith(cut, Truncation::accept);
        if (!before) continue;
        ++accepted;
        EXPECT_EQ(before->digest, digestOf(before->scans)) << "at " << cut.size();
    }
    const bool isMetadata = std::string(GetParam().file) == "/metadata.yaml";
    EXPECT_GE(refused, isMetadata ? 50 : 100);
    if (std::string(GetParam().file).empty()) {
        EXPECT_GT(accepted, 3);  // the pages of SQLite are not in the order of its rows
    }
}

TEST_P(BrokenRos, randomBytes) {
    std::mt19937 random(7);
    int refused = 0;
    for (int i = 0; i < 100; ++i) {
        auto changed = whole_;
        for (int k = i % 2 == 0 ? 100 : 1; k > 0; --k)
            changed[random() % changed.size()] = static_cast<char>(random());
        const auto built = buildWith(changed, Truncation::error);
        refused += !built;
        if (built && GetParam().changes == Changes::always) {
            EXPECT_EQ(built->digest, expected_.digest) << "silently, change " << i;
        }
    }
    EXPECT_GT(refused, 25);
}

INSTANTIATE_TEST_SUITE_P(
    Samples, BrokenRos,
    testing::Values(Sample{"ros1/tf_none.bag", "", Changes::sometimes},
                    Sample{"ros1/tf_bz2.bag", "", Changes::sometimes},
                    Sample{"ros1/tf_lz4.bag", "", Changes::sometimes},
                    Sample{"ros2/little.db3", "", Changes::sometimes},
                    Sample{"ros2/big.db3", "", Changes::sometimes},
                    Sample{"ros2/plain.mcap", "", Changes::always},
                    Sample{"ros2/unchunked.mcap", "", Changes::always},
                    Sample{"ros2/lz4.mcap", "", Changes::always},
                    Sample{"ros2/zstd.mcap", "", Changes::always},
                    Sample{"ros2/split", "/split_1.db3", Changes::sometimes},
                    Sample{"ros2/split", "/metadata.yaml", Changes::sometimes}));

}  // namespace
}  // namespace superray
