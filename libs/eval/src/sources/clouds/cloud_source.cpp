// SPDX-License-Identifier: BSD-3-Clause
// One PCD, PLY or LAS file, or a folder of them, a scan each.

#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include "sources/clouds/cloud_files.h"
#include "sources/clouds/sensor_points.h"
#include "sources/folders/frame_source.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

bool is(const char* extension, const fs::path& path) {
    return equalIgnoringCase(path.extension().string(), extension);
}

mrpt::maps::CSimplePointsMap::Ptr readCloud(const fs::path& path) {
    try {
        if (is(".ply", path)) return readPly(path.string());
        if (is(".las", path)) return readLas(path.string());
        return readPcd(path.string());
    } catch (const FarCoordinate& e) {
        throw InputError(path.string() + ": " + e.what() +
                         ". Move it: las2las -translate_xyz, or pdal translate with "
                         "filters.transformation");
    }
}

}  // namespace

std::vector<std::string> cloudExtensions() {
    return {".pcd", ".ply", ".las", ".laz"};
}

std::unique_ptr<ScanSource> openClouds(const std::string& path,
                                       const ScanSourceOptions& options) {
    FrameRecording recording;
    recording.path = path;
    recording.label = "CLOUD";
    std::vector<fs::path> files = {path};
    if (fs::is_directory(path)) files = listFrames(path, cloudExtensions());
    if (files.empty()) throwNoScans(path, options, {});
    addNamedFrames(files, recording);
    refuseTwins(recording);
    std::uint64_t viewpoints = 0;
    for (Frame& frame : recording.frames) {
        if (is(".laz", frame.file)) throwIsLaz(frame.file.string());
        if (options.poses == PoseOrigin::input && is(".pcd", frame.file))
            frame.T_map_robot = readPcdViewpoint(frame.file.string());
        viewpoints += frame.T_map_robot.has_value();
    }
    // A sensor that starts at the origin has a viewpoint that looks like none.
    if (viewpoints > 0 && !recording.frames.front().T_map_robot)
        recording.frames.front().T_map_robot.emplace();
    recording.ownPoses = PoseSummary("viewpoints of the files", viewpoints);
    recording.read = [](const Frame& frame) -> mrpt::obs::CObservation::Ptr {
        auto observation = mrpt::obs::CObservationPointCloud::Create();
        observation->pointcloud = readCloud(frame.file);
        return observation;
    };
    return makeFrameSource(std::move(recording), options);
}

}  // namespace superray
