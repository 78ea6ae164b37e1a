// SPDX-License-Identifier: BSD-3-Clause
// superray-bench: how fast, how exact and how large, next to others.

#include "commands.h"

namespace {

constexpr char kDescription[] =
    R"(Benchmarks of occupancy mapping engines on recorded and simulated scans.

  superray-bench compare indoor --resolutions 0.1,0.2 --engines octomap,grid,octree
  superray-bench accuracy indoor outdoor --resolutions 0.2
  superray-bench paper indoor -o paper_indoor
  superray-bench realtime drive.rawlog --rate 10 --resolution 0.2
  superray-bench simulate outdoor -o campus.rawlog
  superray-bench soak outdoor --window 30

'superray-bench COMMAND --help' explains a command, with examples.)";

}  // namespace

int main(int argc, char** argv) {
    using namespace superray;
    return runProgram(
        "superray-bench", kDescription,
        {{"compare", "Time, work, memory and contents of engines on the same scans",
          declareCompare},
         {"accuracy", "How true the maps are: test points, exact geometry, moving things",
          declareAccuracy},
         {"paper", "The paper's tables and figures for any data", declarePaper},
         {"realtime", "Scans at the sensor's rate: how many are lost, and how good is the map",
          declareRealtime},
         {"simulate", "Write the scans of a simulated world as a recording", declareSimulate},
         {"soak", "A drive without end: does a map with a window keep to its memory",
          declareSoak}},
        argc, argv);
}
