// SPDX-License-Identifier: BSD-3-Clause
#include <superray/slam/trajectory_error.h>

#include <iostream>
#include <memory>

#include "commands.h"

namespace superray {

Command declareEvaluate(CLI::App& app) {
    struct Arguments {
        std::string estimate, truth;
        TrajectoryErrorOptions options;
        bool json = false;
    };
    auto arguments = std::make_shared<Arguments>();
    app.footer(
        "ATE: distances of the positions after the rigid motion that fits best (Umeyama,\n"
        "without scale). RPE: error of the motion from one pose to the next. Segments: mean\n"
        "error of the motion along so much of the path, as in the KITTI benchmark. Drift:\n"
        "distance of the last poses, the first ones laid on each other, per path length.\n"
        "True poses are interpolated at the times of the estimates.\n\n"
        "Examples:\n"
        "  superray-slam evaluate drive.tum truth.tum\n"
        "  superray-slam evaluate drive.tum truth.tum --segments 5,10,20 --json\n");
    app.add_option("ESTIMATE", arguments->estimate,
                   "TUM (t x y z qx qy qz qw) or MRPT (t x y z yaw pitch roll) text")
        ->required()
        ->type_name("FILE");
    app.add_option("TRUTH", arguments->truth, "Likewise")->required()->type_name("FILE");
    app.add_option("--segments", arguments->options.segmentLengths,
                   "Lengths; default: 100,200,...,800 where the path has 200 m, else a tenth, "
                   "a quarter and half of it")
        ->delimiter(',')
        ->type_name("METRES");
    app.add_option("--step", arguments->options.relativeStep,
                   "Poses between the two that RPE compares; default 1")
        ->type_name("N");
    app.add_flag("--json", arguments->json, "One JSON object (m, rad)");
    return [arguments] {
        const auto error =
            compareTrajectories(Trajectory::load(arguments->estimate),
                                Trajectory::load(arguments->truth), arguments->options);
        std::cout << (arguments->json ? describeAsJson(error) : describe(error));
        return int{kSuccess};
    };
}

}  // namespace superray
