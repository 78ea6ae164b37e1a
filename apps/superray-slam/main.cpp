// SPDX-License-Identifier: BSD-3-Clause
// superray-slam: trajectory and map from range scans without poses.

#include "commands.h"

namespace {

constexpr char kDescription[] =
    R"(SLAM with range sensors in six degrees of freedom: scans without poses in,
trajectory and occupancy map out.

  superray-slam build drive.rawlog -o drive.tum drive.srmap
  superray-slam evaluate drive.tum truth.tum
  superray-slam options

'superray-slam COMMAND --help' explains a command, with examples.)";

}  // namespace

int main(int argc, char** argv) {
    using namespace superray;
    return runProgram(
        "superray-slam", kDescription,
        {{"build", "Make trajectory and map from recorded scans", declareBuild},
         {"evaluate", "Errors of a trajectory against the true one", declareEvaluate},
         {"options", "Print every option of the configuration file", declareOptions}},
        argc, argv);
}
