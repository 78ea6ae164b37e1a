// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The scans of tests/data/formats, as tests/data/formats/make_samples.py makes them.

#include <mrpt/obs/CObservation3DRangeScan.h>
#include <superray/eval/map_build.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <string>

#include "eval/recorded_scans.h"
#include "eval/temp_folder.h"

namespace superray::test {

using mrpt::poses::CPose3D;

inline std::string sample(const std::string& name) {
    return std::string(SUPERRAY_TEST_DATA_DIR) + "/formats/" + name;
}

/// As make_samples.py.
inline mrpt::obs::CObservationPointCloud::Ptr sampleScan(int scan) {
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->timestamp = at(1000 + 0.5 * scan);
    auto points = mrpt::maps::CSimplePointsMap::Create();
    for (int i = 0; i < 60; ++i)
        points->insertPoint(static_cast<float>((i * 37 + scan * 11) % 200 - 100) / 16.0f,
                            static_cast<float>((i * 53 + scan * 7) % 160 - 80) / 16.0f,
                            static_cast<float>((i * 29) % 40 - 20) / 16.0f);
    cloud->pointcloud = points;
    return cloud;
}

inline CPose3D samplePose(int scan) {
    return CPose3D(0.013 + 0.5 * scan, 0.027 - 0.25 * scan, 0.041 + 0.125 * scan, 0, 0, 0);
}

inline mrpt::obs::CObservation3DRangeScan::Ptr sampleImage(int scan) {
    auto image = mrpt::obs::CObservation3DRangeScan::Create();
    image->timestamp = at(1000 + 0.5 * scan);
    image->hasRangeImage = true;
    image->range_is_depth = true;
    image->rangeUnits = 1.0f / 5000;
    image->maxRange = 100;
    image->cameraParams.ncols = 32;
    image->cameraParams.nrows = 24;
    image->cameraParams.setIntrinsicParamsFromValues(30, 31, 15.4, 11.6);
    // The ground truth is that of the optical frame.
    image->sensorPose = -CPose3D(0, 0, 0, -M_PI / 2, 0, -M_PI / 2);
    image->rangeImage.setSize(24, 32);
    for (int r = 0; r < 24; ++r)
        for (int c = 0; c < 32; ++c)
            image->rangeImage(r, c) =
                (r + c) % 7 == 0
                    ? std::uint16_t{0}
                    : static_cast<std::uint16_t>(5000 + 100 * r + 50 * c + 700 * scan);
    return image;
}

struct Built {
    std::string digest, poses;
    std::uint64_t scans = 0;
};

inline Built build(const std::string& path, const ScanSourceOptions& options = {}) {
    ScanSources sources;
    sources.push_back(openScanSource(path, options));
    CSuperRayGridMap3D map(0.3);
    const auto report = buildMap(sources, map, std::numeric_limits<std::uint64_t>::max(),
                                 [](const BuildProgress&) {});
    return {map.digest(), report.poses.front(), report.scans};
}

/// The map of the samples, given as a rawlog.
inline std::string expectedDigest(bool images = false) {
    TempFolder folder;
    Objects objects;
    for (int i = 0; i < 3; ++i) {
        objects.push_back(makePose(1000 + 0.5 * i, samplePose(i)));
        if (images)
            objects.push_back(sampleImage(i));
        else
            objects.push_back(sampleScan(i));
    }
    return build(writeRawlog(folder / "a.rawlog", objects)).digest;
}

inline ScanSourceOptions withPoses(const std::string& file) {
    ScanSourceOptions options;
    options.poses = PoseOrigin::file;
    options.posesFile = file;
    return options;
}

inline ScanSourceOptions sampleCamera() {
    ScanSourceOptions options;
    options.depthCamera.fx = 30;
    options.depthCamera.fy = 31;
    options.depthCamera.cx = 15.4;
    options.depthCamera.cy = 11.6;
    return options;
}

}  // namespace superray::test
