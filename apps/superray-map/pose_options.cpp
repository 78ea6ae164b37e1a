// SPDX-License-Identifier: BSD-3-Clause
#include "pose_options.h"

#include <superray/eval/input_error.h>

#include <vector>

namespace superray {

namespace {

/// A label chooses among what is recorded, and of that not among actions.
void checkLabel(PoseOrigin origin, const std::string& option, const ScanSourceOptions& source) {
    const bool hasLabels = origin != PoseOrigin::file && origin != PoseOrigin::fixed &&
                           origin != PoseOrigin::actions;
    if (!hasLabels && !source.poseLabel.empty())
        throw InputError("--pose-label " + source.poseLabel + " contradicts " + option +
                         ": these poses have no labels");
}

}  // namespace

void addPoseOptions(CLI::App& app, PoseArguments& arguments, ScanSourceOptions& source) {
    auto* poses = app.add_option("--poses", source.posesFile,
                                 "Robot poses: TUM (t x y z qx qy qz qw) or MRPT (t x y z yaw "
                                 "pitch roll) text; KITTI (12 columns) for KITTI folders")
                      ->type_name("FILE");
    app.add_flag("--fixed-robot", arguments.fixedRobot, "The robot stays at the map's origin")
        ->excludes(poses);
    app.add_option("--pose-source", arguments.source,
                   "auto (default), poses, odometry, actions, file or fixed: where the robot "
                   "poses of a .rawlog or a bag of ROS come from")
        ->type_name("SOURCE");
    app.add_option("--pose-label", source.poseLabel,
                   "Label of the robot poses or of the odometry to use; two labels, separated "
                   "by a comma: poses that fix an odometry to the map")
        ->type_name("LABEL");
    app.add_option("--max-pose-gap", source.maxPoseGap,
                   "Scans between poses that are farther apart in time are left out; default 2")
        ->type_name("SECONDS");
}

void addDepthCameraOptions(CLI::App& app, ScanSourceOptions& source) {
    DepthCamera& camera = source.depthCamera;
    app.add_option_function<std::vector<double>>(
           "--intrinsics",
           [&camera](const std::vector<double>& v) {
               camera.fx = v[0];
               camera.fy = v[1];
               camera.cx = v[2];
               camera.cy = v[3];
           },
           "Camera of RGB-D folders: fx fy cx cy; default 525 525 319.5 239.5")
        ->expected(4)
        ->type_name("PIXELS");
    app.add_option("--depth-units", camera.unitsPerMetre,
                   "Value of a metre in the depth images of RGB-D folders; default 5000")
        ->type_name("VALUE");
}

PoseOrigin poseOrigin(const PoseArguments& arguments, const ScanSourceOptions& source) {
    const bool hasFile = !source.posesFile.empty();
    const PoseOrigin origin = hasFile                ? PoseOrigin::file
                              : arguments.fixedRobot ? PoseOrigin::fixed
                                                     : PoseOrigin::input;
    if (arguments.source.empty()) {
        checkLabel(origin, hasFile ? "--poses" : "--fixed-robot", source);
        return origin;
    }
    const PoseOrigin asked = poseOriginFromString(arguments.source);
    if (asked == PoseOrigin::file && !hasFile)
        throw InputError("--pose-source file needs --poses FILE");
    if (origin != PoseOrigin::input && asked != origin)
        throw InputError("--pose-source " + arguments.source + " contradicts " +
                         (hasFile ? "--poses" : "--fixed-robot"));
    checkLabel(asked, "--pose-source " + arguments.source, source);
    return asked;
}

}  // namespace superray
