// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CObservation3DRangeScan.h>

#include <algorithm>
#include <cmath>

#include "sources/clouds/scalar_field.h"
#include "sources/ros/ros_scans.h"

namespace superray {
namespace {

using mrpt::obs::CObservation3DRangeScan;
using mrpt::poses::CPose3D;

struct ImageShape {
    std::uint32_t rows = 0, columns = 0;
    std::string encoding;
};

ImageShape readShape(MessageCursor& in) {
    ImageShape shape;
    shape.rows = in.number<std::uint32_t>();
    shape.columns = in.number<std::uint32_t>();
    shape.encoding = in.text();
    return shape;
}

constexpr const char *kMillimetres = "16UC1", *kMetres = "32FC1";

void setCamera(const RosCamera& camera, Rectification done, CObservation3DRangeScan& scan) {
    auto& to = scan.cameraParams;
    to.ncols = camera.columns;
    to.nrows = camera.rows;
    const auto& k = camera.intrinsics;
    const auto& p = camera.projection;
    const bool isRectified = done == Rectification::done && p[0] > 0;
    if (isRectified)
        to.setIntrinsicParamsFromValues(p[0], p[5], p[2], p[6]);
    else
        to.setIntrinsicParamsFromValues(k[0], k[4], k[2], k[5]);
    if (!(to.fx() > 0 && to.fy() > 0 && std::isfinite(to.fx() + to.fy() + to.cx() + to.cy())))
        throw MalformedBytes("the CameraInfo has no focal lengths");
    bool isDistorted = false;
    for (const double d : camera.distortion) isDistorted = isDistorted || d != 0;
    if (isRectified || !isDistorted) return;
    if (camera.distortionModel != "plumb_bob" || camera.distortion.size() > 5)
        throw MalformedBytes("the CameraInfo has the distortion model '" +
                             camera.distortionModel +
                             "'; read are plumb_bob and rectified images: see image_proc");
    to.distortion = mrpt::img::DistortionModel::plumb_bob;
    std::copy(camera.distortion.begin(), camera.distortion.end(), to.dist.begin());
}

/// Points of depths that are reals, which MRPT's images have no place for.
void addPoints(const ImageShape& shape, const char* data, std::size_t step, ByteOrder order,
               CObservation3DRangeScan& scan) {
    const auto& camera = scan.cameraParams;
    if (camera.distortion != mrpt::img::DistortionModel::none)
        throw MalformedBytes("a 32FC1 image must be rectified: see image_proc");
    scan.hasPoints3D = true;
    const ScalarField real;
    for (std::size_t r = 0; r < shape.rows; ++r)
        for (std::size_t c = 0; c < shape.columns; ++c) {
            const auto depth = static_cast<float>(real.read(data + r * step + 4 * c, order));
            if (!std::isfinite(depth) || depth <= 0) continue;
            const double across = (static_cast<double>(c) - camera.cx()) / camera.fx();
            const double down = (static_cast<double>(r) - camera.cy()) / camera.fy();
            scan.points3D_idxs_x.push_back(static_cast<std::uint16_t>(c));
            scan.points3D_idxs_y.push_back(static_cast<std::uint16_t>(r));
            scan.points3D_x.push_back(depth);
            scan.points3D_y.push_back(static_cast<float>(-across * static_cast<double>(depth)));
            scan.points3D_z.push_back(static_cast<float>(-down * static_cast<double>(depth)));
        }
}

void addImage(const ImageShape& shape, const char* data, std::size_t step, ByteOrder order,
              CObservation3DRangeScan& scan) {
    scan.hasRangeImage = true;
    scan.range_is_depth = true;
    scan.rangeUnits = 0.001f;
    scan.rangeImage.setSize(static_cast<int>(shape.rows), static_cast<int>(shape.columns));
    for (std::uint32_t r = 0; r < shape.rows; ++r)
        for (std::uint32_t c = 0; c < shape.columns; ++c) {
            const auto* at = reinterpret_cast<const unsigned char*>(data + r * step + 2 * c);
            const unsigned value =
                order == ByteOrder::big ? at[0] * 256u + at[1] : at[1] * 256u + at[0];
            scan.rangeImage(static_cast<int>(r), static_cast<int>(c)) =
                static_cast<std::uint16_t>(value);
        }
}

}  // namespace

bool RosCamera::operator==(const RosCamera& o) const {
    return columns == o.columns && rows == o.rows && distortionModel == o.distortionModel &&
           distortion == o.distortion && intrinsics == o.intrinsics &&
           projection == o.projection && isPartial == o.isPartial;
}

RosCamera readCameraInfo(MessageCursor& in) {
    readHeader(in);
    RosCamera camera;
    camera.rows = in.number<std::uint32_t>();
    camera.columns = in.number<std::uint32_t>();
    camera.distortionModel = in.text();
    camera.distortion = in.sequence<double>();
    camera.intrinsics = in.numbers<double, 9>();
    in.numbers<double, 9>();  // R: what rectified the image
    camera.projection = in.numbers<double, 12>();
    const auto binning = in.numbers<std::uint32_t, 2>();
    const auto region = in.numbers<std::uint32_t, 4>();  // x, y, height, width
    in.number<std::uint8_t>();                           // do_rectify
    in.expectEnd();
    const bool isWhole = (region[2] == 0 || region[2] == camera.rows) &&
                         (region[3] == 0 || region[3] == camera.columns);
    camera.isPartial =
        binning[0] > 1 || binning[1] > 1 || region[0] > 0 || region[1] > 0 || !isWhole;
    return camera;
}

bool isDepthImage(MessageCursor in) {
    readHeader(in);
    const std::string encoding = readShape(in).encoding;
    return encoding == kMillimetres || encoding == kMetres;
}

RosScan readDepthImage(MessageCursor& in, const RosCamera& camera, Rectification done) {
    const RosHeader header = readHeader(in);
    const ImageShape shape = readShape(in);
    const ByteOrder order = in.number<std::uint8_t>() != 0 ? ByteOrder::big : ByteOrder::little;
    const std::size_t step = in.number<std::uint32_t>();
    const auto data = in.bytes();
    in.expectEnd();
    const std::size_t pixel = shape.encoding == kMillimetres ? 2 : 4;
    if (step < shape.columns * pixel || data.size() != step * shape.rows || data.empty())
        throw MalformedBytes("its " + std::to_string(data.size()) + " bytes are not " +
                             std::to_string(shape.rows) + " rows of " + std::to_string(step) +
                             " bytes with " + std::to_string(shape.columns) + " pixels each");
    if (shape.rows != camera.rows || shape.columns != camera.columns || camera.isPartial)
        throw MalformedBytes(
            "it has " + std::to_string(shape.columns) + " x " + std::to_string(shape.rows) +
            " pixels, its CameraInfo is of " + (camera.isPartial ? "a part of " : "") +
            std::to_string(camera.columns) + " x " + std::to_string(camera.rows));
    auto scan = CObservation3DRangeScan::Create();
    scan->timestamp = header.time;
    scan->maxRange = 0;  // not known
    setCamera(camera, done, *scan);
    if (pixel == 2)
        addImage(shape, data.data(), step, order, *scan);
    else
        addPoints(shape, data.data(), step, order, *scan);
    // The frame is optical: x right, y down, z forward. MRPT's has x forward and z up.
    scan->sensorPose = -CPose3D(0, 0, 0, -M_PI / 2, 0, -M_PI / 2);
    return {header.frame, scan};
}

}  // namespace superray
