// SPDX-License-Identifier: BSD-3-Clause
// superray-map: maps from recorded scans, at the command line.

#include "commands.h"

namespace {

constexpr char kDescription[] =
    R"(Exact occupancy maps from recorded scans, by super rays and culling regions.

  superray-map inspect drive.rawlog
  superray-map build drive.rawlog -o drive.srmap --resolution 0.1
  superray-map info drive.srmap
  superray-map export drive.srmap drive.ot
  superray-map compare drive.srmap other.ot

'superray-map COMMAND --help' explains a command, with examples.)";

}  // namespace

int main(int argc, char** argv) {
    using namespace superray;
    return runProgram(
        "superray-map", kDescription,
        {{"build", "Make a map from recorded scans", declareBuild},
         {"inspect", "What a recording holds, and what build would do", declareInspect},
         {"info", "What a map is and holds", declareInfo},
         {"export", "Write a map for other programs", declareExport},
         {"compare", "How two maps differ", declareCompare}},
        argc, argv);
}
