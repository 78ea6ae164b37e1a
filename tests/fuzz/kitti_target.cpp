// SPDX-License-Identifier: BSD-3-Clause
// Folders of the KITTI odometry benchmark: calibration, poses, times and a scan, with a
// byte 1 between them.

#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>

#include <filesystem>

#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    const std::string identity = "1 0 0 0 0 1 0 0 0 0 1 0\n";
    return {"Tr: " + identity + '\1' + identity + '\1' + "0.5\n" + '\1' + std::string(64, '@')};
}

void run(const std::string& input) {
    const char* const names[] = {"k/calib.txt", "k/poses.txt", "k/times.txt",
                                 "k/velodyne/000000.bin"};
    std::string folder;
    std::size_t at = 0;
    for (const char* name : names) {
        const std::size_t end = std::min(input.find('\1', at), input.size());
        const auto path = asFile(input.substr(at, end - at), name);
        if (folder.empty()) folder = std::filesystem::path(path).parent_path().string();
        at = std::min(end + 1, input.size());
    }
    try {
        const auto source = openScanSource(folder, {});
        while (source->next()) continue;
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
