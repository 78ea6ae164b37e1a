// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/recording_info.h>

#include <iostream>
#include <memory>

#include "commands.h"
#include "pose_options.h"

namespace superray {

Command declareInspect(CLI::App& app) {
    struct Arguments {
        std::string input;
        ScanSourceOptions source;
        PoseArguments poses;
        bool json = false;
    };
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    app.footer(
        "Says what a recording holds: sensors by label and class, times, rates and ranges,\n"
        "poses, external files; and what 'superray-map build' with the same options would\n"
        "do, or why it would not.\n\n"
        "Examples:\n"
        "  superray-map inspect drive.rawlog\n"
        "  superray-map inspect drive.rawlog --json | jq .build.possible\n");
    app.add_option("INPUT", a.input, "Recorded scans")->required()->type_name("FILE");
    app.add_option("--sensor", a.source.sensorLabel,
                   "Sensor labels to use, comma-separated; default: all")
        ->type_name("LABELS");
    addPoseOptions(app, a.poses, a.source);
    addDepthCameraOptions(app, a.source);
    app.add_flag("--json", a.json, "One JSON object instead of text");
    return [arguments] {
        ScanSourceOptions options = arguments->source;
        options.poses = poseOrigin(arguments->poses, options);
        const RecordingInfo info = inspectRecording(arguments->input, options);
        std::cout << (arguments->json ? describeAsJson(info) : describe(info));
        return int{kSuccess};
    };
}

}  // namespace superray
