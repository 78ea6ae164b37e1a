// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/pose_noise.h>
#include <superray/eval/seeded_random.h>

#include <Eigen/Geometry>
#include <cmath>

namespace superray {
namespace {

constexpr double kRadiansPerDegree = 0.017453292519943295;
constexpr std::uint64_t kStream = 1u << 20;  // none that test points use

Eigen::Vector3d draw(SeededRandom& random, double sigma) {
    const double x = random.bell(sigma), y = random.bell(sigma), z = random.bell(sigma);
    return {x, y, z};
}

}  // namespace

void PoseNoise::validate() const {
    for (const double sigma : {metres, degrees})
        if (!(sigma >= 0 && std::isfinite(sigma)))
            throw InputError("the pose noise has a sigma of " + std::to_string(sigma) +
                             "; must be finite and >= 0");
}

void addPoseNoise(std::vector<PointScan>& scans, const PoseNoise& noise, std::uint64_t seed) {
    if (noise.none()) return;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        SeededRandom random(seed, kStream + i);
        const Eigen::Vector3d shift = draw(random, noise.metres);
        const Eigen::Vector3d turn = draw(random, noise.degrees * kRadiansPerDegree);
        const double angle = turn.norm();
        Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
        if (angle > 0) rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
        const Eigen::Vector3d origin = scans[i].origin.cast<double>();
        for (Eigen::Vector3f& p : scans[i].points)
            p = (rotation * (p.cast<double>() - origin) + origin + shift).cast<float>();
        scans[i].origin = (origin + shift).cast<float>();
    }
}

}  // namespace superray
