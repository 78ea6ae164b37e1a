// SPDX-License-Identifier: BSD-3-Clause
// Point cloud files. The first byte chooses the kind.

#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include "eval/insert_scans.h"
#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    std::vector<std::string> all;
    for (const char* kind : {"pcd_ascii", "pcd_binary", "pcd_compressed"})
        all.push_back("p" + testData(std::string("formats/") + kind + "/1000.500000.pcd"));
    for (const char* kind : {"ply_ascii", "ply_binary"})
        all.push_back("y" + testData(std::string("formats/") + kind + "/1000.500000.ply"));
    return all;
}

void run(const std::string& input) {
    if (input.empty()) return;
    const auto path = asFile(input.substr(1), input[0] % 2 != 0 ? "input.ply" : "input.pcd");
    ScanSourceOptions options;
    options.poses = PoseOrigin::fixed;
    try {
        test::insertWhatCanBe(*openScanSource(path, options));
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
