// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/point_scan.h>
#include <superray/maps/observation_rays.h>

#include <algorithm>
#include <filesystem>

namespace superray {
namespace {

PointScan inMapFrame(const mrpt::poses::CPose3D& T_map_sensor,
                     const std::vector<Eigen::Vector3f>& points) {
    Eigen::Matrix3d R;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) R(r, c) = T_map_sensor.getRotationMatrix()(r, c);
    const Eigen::Vector3d t(T_map_sensor.x(), T_map_sensor.y(), T_map_sensor.z());
    PointScan scan;
    scan.origin = t.cast<float>();
    scan.points.reserve(points.size());
    for (const Eigen::Vector3f& p : points)
        if (p.allFinite()) scan.points.push_back((R * p.cast<double>() + t).cast<float>());
    return scan;
}

void add(PointScans& all, PointScan scan) {
    if (scan.points.empty()) return;
    all.points += scan.points.size();
    all.bounds.extend(scan.origin);
    for (const Eigen::Vector3f& p : scan.points) all.bounds.extend(p);
    all.scans.push_back(std::move(scan));
}

}  // namespace

PointScan toPointScan(const Scan& scan) {
    const auto returns = readReturns(*scan.observation, {});
    if (!returns) return {};
    return inMapFrame(scan.T_map_robot + returns->sensorOnRobot, returns->hits);
}

PointScans loadPointScans(const PointScanRequest& request, const LoadProgress& progress) {
    PointScans all;
    const auto tell = [&](std::uint64_t done, std::uint64_t total) {
        if (progress) progress(done, total);
    };
    if (SimulatedWorld::isName(request.data)) {
        if (request.source.maxScans == 0) throw InputError("scans = 0: must be at least 1");
        all.name = request.data;
        const SimulatedWorld world(request.data, request.worldSeed);
        const auto total = std::min<std::uint64_t>(world.scanCount(), request.source.maxScans);
        for (std::uint64_t i = 0; i < total; ++i) {
            const SimulatedScan scan = world.scan(i, request.noise);
            add(all, inMapFrame(scan.T_map_robot + scan.T_robot_sensor, scan.points));
            tell(i + 1, total);
        }
        return all;
    }
    const auto source = openScanSource(request.data, request.source);
    checkSensorLabels(request.source.sensorLabel, source->sensorLabels());
    std::uint64_t done = 0;
    while (const auto scan = source->next()) {
        add(all, toPointScan(*scan));
        tell(++done, source->total());
    }
    if (all.scans.empty())
        throw InputError(request.data + ": none of its scans has ranges or points");
    // A folder may be given as "folder/".
    const std::filesystem::path path = std::filesystem::path(request.data) / "";
    all.name = path.parent_path().stem().string();
    return all;
}

}  // namespace superray
