// SPDX-License-Identifier: BSD-3-Clause
// Recordings of ROS 1 and 2, told by their contents, and what they would be after a kill.

#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include "eval/insert_scans.h"
#include "fuzz/target.h"

namespace superray::fuzz {
namespace {

void read(const std::string& path, const ScanSourceOptions& options) {
    try {
        test::insertWhatCanBe(*openScanSource(path, options));
    } catch (const InputError&) {
    }
}

}  // namespace

std::vector<std::string> seeds() {
    std::vector<std::string> all;
    for (const char* name :
         {"ros1/tf_none.bag", "ros1/tf_bz2.bag", "ros1/tf_lz4.bag", "ros1/layouts.bag",
          "ros1/laser.bag", "ros2/unchunked.mcap", "ros2/plain.mcap", "ros2/lz4.mcap",
          "ros2/zstd.mcap", "ros2/little.db3", "ros2/big.db3"})
        all.push_back(testData(std::string("formats/") + name));
    return all;
}

void run(const std::string& input) {
    const auto path = asFile(input, "input");
    ScanSourceOptions options;
    options.truncation = Truncation::accept;
    options.poseLabel = "tf map";
    read(path, options);
    options.poseLabel = "/odom";
    read(path, options);
    options.poseLabel.clear();
    options.poses = PoseOrigin::fixed;
    read(path, options);
}

}  // namespace superray::fuzz
