// The likelihood finds the true pose in a map of a real room.

#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>

#include <chrono>

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

}  // namespace
}  // namespace superray
