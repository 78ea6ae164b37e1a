// SPDX-License-Identifier: BSD-3-Clause
// Point cloud files, and captures of a Velodyne.

#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include <array>

#include "eval/insert_scans.h"
#include "fuzz/target.h"

namespace superray::fuzz {
namespace {

/// The first byte of an input, modulo their number, chooses one.
constexpr std::array<const char*, 4> kExtensions{"pcd", "ply", "las", "pcap"};

}  // namespace

std::vector<std::string> seeds() {
    std::vector<std::string> all;
    const auto add = [&](char kind, const std::string& name) {
        all.push_back(kind + testData("formats/" + name));
    };
    for (const char* name : {"pcd_ascii", "pcd_binary", "pcd_compressed"})
        add('0', std::string(name) + "/1000.500000.pcd");
    for (const char* name : {"ply_ascii", "ply_binary"})
        add('1', std::string(name) + "/1000.500000.ply");
    for (const char* name : {"las", "las_1_4"})
        add('2', std::string(name) + "/1000.500000.las");
    for (const char* name : {"plain", "tagged"})
        add('3', "velodyne/" + std::string(name) + ".pcap");
    return all;
}

void run(const std::string& input) {
    if (input.empty()) return;
    const auto kind = static_cast<unsigned char>(input[0]) % kExtensions.size();
    const auto path = asFile(input.substr(1), std::string("input.") + kExtensions[kind]);
    ScanSourceOptions options;
    options.poses = PoseOrigin::fixed;
    try {
        test::insertWhatCanBe(*openScanSource(path, options));
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
