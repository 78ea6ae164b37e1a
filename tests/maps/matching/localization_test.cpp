// SPDX-License-Identifier: BSD-3-Clause
// The likelihood finds the true pose in a map of a real room.

#include <mrpt/obs/CObservationRotatingScan.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <iostream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

constexpr std::size_t kTrials = 1000;

/// A pose that is off by at least 5 cm or at least 2 degrees (up to three times
/// as much), in any direction.
CPose3D perturbed(const CPose3D& truth, std::mt19937& random) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> factor(1, 3);
    const auto direction = [&] {
        return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    };
    const bool shifted = random() % 2 == 0;
    const Eigen::Vector3d t = shifted ? Eigen::Vector3d(direction() * (0.05 * factor(random)))
                                      : Eigen::Vector3d::Zero();
    const double angle = shifted ? 0.0 : 2 * M_PI / 180 * factor(random);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, direction()).toRotationMatrix();
    mrpt::math::CMatrixDouble44 T;
    T.setIdentity();
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) T(r, c) = R(r, c);
        T(r, 3) = t[r];
    }
    return truth + CPose3D(T);
}

template <class Map>
void expectTheTruePoseWins() {
    const std::string file = std::string(SUPERRAY_SHARED_DATA_DIR) + "/rgbd_room.rawlog";
    SUPERRAY_SKIP_WITHOUT(file);
    const auto scans = test::readScans(file, 100);
    ASSERT_EQ(scans.size(), 100u);
    Map map(0.05);
    map.insertionOptions.decimation = 7;
    map.likelihoodOptions.sigma = 0.05;
    map.likelihoodOptions.maxDistance = 0.3;
    map.likelihoodOptions.decimation = 97;
    for (const auto& s : scans) ASSERT_TRUE(map.insertObservation(*s.scan, s.robotPose));

    std::mt19937 random(20190415);
    std::size_t trials = 0, won = 0;
    while (trials < kTrials) {
        const auto& s = scans[trials % scans.size()];
        const double truth = map.computeObservationLikelihood(*s.scan, s.robotPose);
        for (int i = 0; i < 10; ++i, ++trials)
            won += truth > map.computeObservationLikelihood(*s.scan,
                                                            perturbed(s.robotPose, random))
                       ? 1
                       : 0;
    }
    ASSERT_EQ(trials, kTrials);
    std::cout << map.shortClassName() << ": the true pose wins " << won << " of " << trials
              << " trials\n";
    EXPECT_GE(won, kTrials * 99 / 100);
}

TEST(Localization, TheTruePoseWinsInTheRoom) {
    expectTheTruePoseWins<CSuperRayGridMap3D>();
}

TEST(Localization, EverySupportedObservationPrefersItsPose) {
    const auto velodyne = test::mrptDataset("test_velodyne_VLP16.rawlog");
    const auto camera = test::mrptDataset("tests_rgbd.rawlog");
    SUPERRAY_SKIP_WITHOUT(velodyne);
    SUPERRAY_SKIP_WITHOUT(camera);
    std::vector<mrpt::obs::CObservation::Ptr> scans{test::randomCloud(500, 1),
                                                    test::planarScan(181)};
    scans.push_back(test::readScans(velodyne, 1).at(0).scan);
    scans.push_back(test::readScans(camera, 1).at(0).scan);
    auto rotating = mrpt::obs::CObservationRotatingScan::Create();
    rotating->rowCount = 1;
    rotating->columnCount = 180;
    rotating->rangeImage.resize(1, 180);
    for (int i = 0; i < 180; ++i)
        rotating->rangeImage(0, i) = static_cast<std::uint16_t>(500 + i);
    rotating->rangeResolution = 0.005;
    rotating->startAzimuth = -3;
    rotating->azimuthSpan = 6;
    rotating->minRange = 0.1;
    rotating->maxRange = 30;
    scans.push_back(rotating);
    std::size_t compared = 0;
    for (const auto& className : mapClassNames()) {
        for (const auto& scan : scans) {
            const auto map = createMap(className);
            if (!dynamic_cast<SuperRayMapInterface*>(&*map)) continue;
            // 2D maps leave out scans of a plane that is tilted.
            const bool is2D = dynamic_cast<CSuperRayMapBase<2>*>(&*map) != nullptr;
            const auto truth =
                is2D ? CPose3D(1.5, -2.25, 0.75, 0.8, 0, 0) : test::someRobotPose();
            ASSERT_TRUE(map->insertObservation(*scan, truth));
            ASSERT_TRUE(map->canComputeObservationLikelihood(*scan));
            const double here = map->computeObservationLikelihood(*scan, truth);
            for (const double shift : {-0.4, 0.4}) {
                const auto pose = CPose3D(shift, shift / 2, 0, 0, 0, 0) + truth;
                EXPECT_GT(here, map->computeObservationLikelihood(*scan, pose) + 1)
                    << className << " " << scan->GetRuntimeClass()->className;
                ++compared;
            }
        }
    }
    EXPECT_EQ(compared, 4u * 5u * 2u);
}

}  // namespace
}  // namespace superray
