// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/opengl/stock_objects.h>
#include <superray/eval/output_paths.h>
#include <superray/maps/gzip_output.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/super_ray_map_interface.h>
#include <superray/slam/slam_output.h>

#include <filesystem>

namespace superray {
namespace {

namespace fs = std::filesystem;

void writeScene(const RangeSlam& slam, const std::string& path) {
    GlScene scene;
    auto map = mrpt::opengl::CSetOfObjects::Create();
    slam.map().getVisualizationInto(*map);
    scene.insert(map);
    scene.insert(makeTrajectoryView(slam.trajectory()));
    writeGzip(scene, path);
}

}  // namespace

void checkSlamOutputPath(const std::string& path) {
    checkOutputPath(path, {".tum", ".srmap", ".simplemap", ".3Dscene"});
}

void writeSlamOutput(const RangeSlam& slam, const std::string& path) {
    const std::string extension = fs::path(path).extension().string();
    if (extension == ".tum") return slam.trajectory().saveTum(path);
    if (extension == ".srmap")
        return dynamic_cast<const SuperRayMapInterface&>(slam.map()).saveToFile(path);
    if (extension == ".simplemap") return writeGzip(slam.keyFrames(), path);
    writeScene(slam, path);
}

std::shared_ptr<mrpt::opengl::CSetOfObjects> makeTrajectoryView(const Trajectory& trajectory) {
    auto view = mrpt::opengl::CSetOfObjects::Create();
    auto line = mrpt::opengl::CSetOfLines::Create();
    line->setColor_u8(220, 30, 30);
    line->setLineWidth(3);
    const mrpt::poses::CPose3D* previous = nullptr;
    for (const auto& entry : trajectory.poses()) {
        const mrpt::poses::CPose3D& pose = entry.second;
        if (previous)
            line->appendLine(previous->x(), previous->y(), previous->z(), pose.x(), pose.y(),
                             pose.z());
        previous = &pose;
    }
    view->insert(line);
    if (previous) {
        auto axes = mrpt::opengl::stock_objects::CornerXYZSimple(0.5f, 3);
        axes->setPose(*previous);
        view->insert(axes);
    }
    return view;
}

}  // namespace superray
