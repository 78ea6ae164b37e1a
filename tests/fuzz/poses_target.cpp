// SPDX-License-Identifier: BSD-3-Clause
// Texts of poses.

#include <superray/eval/input_error.h>
#include <superray/eval/trajectory.h>

#include "fuzz/target.h"

namespace superray::fuzz {

std::vector<std::string> seeds() {
    return {"# t x y z qx qy qz qw\n1 0 0 0 0 0 0 1\n2.5 1e-3 -2 +3 0 0 0.6 0.8\n",
            "1 2 3 4 0.1 0.2 0.3\n2 2 3 4 0.1 0.2 0.3\n"};
}

void run(const std::string& input) {
    try {
        const auto trajectory = Trajectory::load(asFile(input, "input.tum"));
        trajectory.at(trajectory.firstTime());
        trajectory.saveTum(asFile("", "output.tum"));
    } catch (const InputError&) {
    }
}

}  // namespace superray::fuzz
