// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/ros_scans.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <cmath>

#include "sources/clouds/scalar_field.h"
#include "sources/clouds/sensor_points.h"

namespace superray {
namespace {

constexpr double kFullCircle = 2 * M_PI;

/// How the points of a PointCloud2 lie in its data.
struct CloudLayout {
    std::uint32_t height = 0, width = 0, pointStep = 0, rowStep = 0;
    ByteOrder order = ByteOrder::little;
    std::array<ScalarField, 3> axes;  ///< x, y, z
};

/// sensor_msgs/PointField: FLOAT32 and FLOAT64.
constexpr std::uint8_t kFloat32 = 7, kFloat64 = 8;

void readFields(MessageCursor& in, CloudLayout& layout) {
    constexpr std::size_t kLeast = 13;  // an empty name and three numbers
    const std::array<std::string, 3> names{"x", "y", "z"};
    std::array<bool, 3> found{};
    for (std::size_t left = in.count(kLeast); left > 0; --left) {
        const std::string name = in.text();
        const auto offset = in.number<std::uint32_t>();
        const auto type = in.number<std::uint8_t>();
        const auto count = in.number<std::uint32_t>();
        for (std::size_t axis = 0; axis < names.size(); ++axis) {
            if (name != names[axis]) continue;
            if ((type != kFloat32 && type != kFloat64) || count > 1 || found[axis])
                throw MalformedBytes("field '" + name +
                                     "' must be one number of type FLOAT32 or FLOAT64");
            found[axis] = true;
            layout.axes[axis].bytes = type == kFloat32 ? 4 : 8;
            layout.axes[axis].offset = offset;
        }
    }
    for (std::size_t axis = 0; axis < names.size(); ++axis)
        if (!found[axis]) throw MalformedBytes("it has no field '" + names[axis] + "'");
}

void checkLayout(const CloudLayout& layout, std::size_t bytes) {
    for (const ScalarField& f : layout.axes)
        if (f.offset + f.bytes > layout.pointStep)
            throw MalformedBytes("a field ends behind its point_step of " +
                                 std::to_string(layout.pointStep) + " bytes");
    const std::uint64_t row = std::uint64_t{layout.width} * layout.pointStep;
    const bool isOneRow = layout.height == 1;  // then row_step means nothing
    const std::uint64_t told =
        isOneRow && bytes == row ? row : std::uint64_t{layout.rowStep} * layout.height;
    if (told != bytes || (!isOneRow && layout.rowStep < row && layout.height > 0))
        throw MalformedBytes("its data have " + std::to_string(bytes) + " bytes; " +
                             std::to_string(layout.height) + " rows of " +
                             std::to_string(layout.width) + " points, point_step " +
                             std::to_string(layout.pointStep) + " and row_step " +
                             std::to_string(layout.rowStep) + " tell another number");
    if (isOneRow && bytes < row) throw MalformedBytes("its row_step is below its points");
}

void addPoints(const CloudLayout& layout, const char* data,
               mrpt::maps::CSimplePointsMap& points) {
    points.reserve(std::size_t{layout.height} * layout.width);
    const auto& [x, y, z] = layout.axes;
    for (std::size_t r = 0; r < layout.height; ++r) {
        const char* point = data + r * (layout.height > 1 ? layout.rowStep : 0);
        for (std::size_t c = 0; c < layout.width; ++c, point += layout.pointStep)
            addSensorPoint(points, x.read(point, layout.order), y.read(point, layout.order),
                           z.read(point, layout.order));
    }
}

}  // namespace

RosScan readPointCloud2(MessageCursor& in) {
    const RosHeader header = readHeader(in);
    CloudLayout layout;
    layout.height = in.number<std::uint32_t>();
    layout.width = in.number<std::uint32_t>();
    readFields(in, layout);
    layout.order = in.number<std::uint8_t>() != 0 ? ByteOrder::big : ByteOrder::little;
    layout.pointStep = in.number<std::uint32_t>();
    layout.rowStep = in.number<std::uint32_t>();
    const auto data = in.bytes();
    in.number<std::uint8_t>();  // is_dense: whether all are finite
    in.expectEnd();
    checkLayout(layout, data.size());
    if (layout.width == 0) layout.height = 0;

    auto points = mrpt::maps::CSimplePointsMap::Create();
    try {
        addPoints(layout, data.data(), *points);
    } catch (const FarCoordinate& e) {
        throw MalformedBytes(e.what());
    }
    points->mark_as_modified();
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->timestamp = header.time;
    cloud->pointcloud = points;
    return {header.frame, cloud};
}

RosScan readLaserScan(MessageCursor& in) {
    const RosHeader header = readHeader(in);
    const double first = static_cast<double>(in.number<float>());
    in.number<float>();  // angle_max: told by the number of ranges, and better
    const double step = static_cast<double>(in.number<float>());
    in.number<float>();  // time_increment
    in.number<float>();  // scan_time
    const auto least = in.number<float>(), most = in.number<float>();
    const auto ranges = in.sequence<float>();
    in.sequence<float>();  // intensities
    in.expectEnd();

    const double steps = ranges.empty() ? 0 : static_cast<double>(ranges.size() - 1);
    const double span = steps * step;
    if (!std::isfinite(first + step) || std::abs(span) > 2 * kFullCircle ||
        (steps > 0 && step == 0))
        throw MalformedBytes(std::to_string(ranges.size()) + " ranges from angle_min " +
                             std::to_string(first) + " in steps of " + std::to_string(step) +
                             " are no scan");
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->timestamp = header.time;
    scan->aperture = static_cast<float>(std::abs(span));
    scan->rightToLeft = step >= 0;
    scan->maxRange = std::isfinite(most) && most > 0 ? most : 0;  // 0: not known
    scan->sensorPose = mrpt::poses::CPose3D(0, 0, 0, first + span / 2, 0, 0);
    scan->resizeScan(ranges.size());
    for (std::size_t i = 0; i < ranges.size(); ++i) {
        const float r = ranges[i];
        const bool isNoReturn = r > 0 && (std::isinf(r) || (scan->maxRange > 0 && r > most));
        const bool isKnown = r >= least && r > 0 && !isNoReturn;
        // A range of 0 that is valid tells nothing, not even of free space.
        scan->setScanRange(i, isKnown ? r : isNoReturn ? scan->maxRange : 0.0f);
        scan->setScanRangeValidity(i, !isNoReturn);
    }
    return {header.frame, scan};
}

}  // namespace superray
