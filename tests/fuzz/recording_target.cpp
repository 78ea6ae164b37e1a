// SPDX-License-Identifier: BSD-3-Clause
// Rawlogs and simplemaps, plain or compressed. The first byte chooses the kind.

#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include "eval/insert_scans.h"
#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    return {"r" + testData("mrpt_2_15.rawlog").substr(0, 20000),
            "s" + testData("mrpt_2_15.simplemap")};
}

void run(const std::string& input) {
    if (input.empty()) return;
    const auto path =
        asFile(input.substr(1), input[0] % 2 != 0 ? "input.simplemap" : "input.rawlog");
    ScanSourceOptions options;
    options.poses = PoseOrigin::fixed;
    options.truncation = Truncation::accept;
    try {
        test::insertWhatCanBe(*openScanSource(path, options));
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
