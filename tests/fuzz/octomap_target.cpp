// SPDX-License-Identifier: BSD-3-Clause
// OctoMap's .ot and .bt files.

#include <octomap/OcTree.h>
#include <superray/eval/input_error.h>
#include <superray/eval/octomap_file.h>

#include <sstream>

#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    octomap::OcTree tree(0.1);
    for (int i = 0; i < 60; ++i)
        tree.updateNode(octomap::point3d(0.1f * static_cast<float>(i % 7), 0.1f, 0.3f),
                        i % 3 != 0);
    tree.prune();
    std::ostringstream full, binary;
    tree.write(full);
    tree.writeBinaryConst(binary);
    return {full.str(), binary.str()};
}

void run(const std::string& input) {
    OctomapLimits limits;
    limits.cellsOfAnyFile = 100000;
    limits.cellsPerByte = 1;
    try {
        readOctomapFile(asFile(input, "input.ot"), limits);
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
