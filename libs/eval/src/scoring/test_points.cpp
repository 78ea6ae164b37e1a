// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/cell.h>
#include <superray/eval/input_error.h>
#include <superray/eval/seeded_random.h>
#include <superray/eval/test_points.h>

namespace superray {
namespace {

constexpr float kCellsBeforeEnd = 2;

}  // namespace

void SplitOptions::validate() const {
    if (!(testShare > 0 && testShare < 1))
        throw InputError("the share of test points is " + std::to_string(testShare) +
                         "; must be between 0 and 1");
    CellGeometry<3>{resolution};
}

TrainTestSplit splitScans(const std::vector<PointScan>& scans, const SplitOptions& options) {
    const auto margin = kCellsBeforeEnd * static_cast<float>(options.resolution);
    TrainTestSplit split;
    for (std::uint32_t i = 0; i < scans.size(); ++i) {
        SeededRandom random(options.seed, i);
        PointScan training;
        training.origin = scans[i].origin;
        for (std::uint32_t n = 0; n < scans[i].points.size(); ++n) {
            const Eigen::Vector3f& p = scans[i].points[n];
            const bool tested = random.uniform() < options.testShare;
            if (!tested || options.training == TrainingPoints::all)
                training.points.push_back(p);
            if (!tested) continue;
            split.tests.push_back({p, true, i, n});
            const Eigen::Vector3f ray = p - scans[i].origin;
            const float length = ray.norm();
            if (length <= margin) continue;
            const auto t = static_cast<float>(random.uniform()) * (length - margin);
            split.tests.push_back({scans[i].origin + ray * (t / length), false, i, n});
        }
        split.training.push_back(std::move(training));
    }
    return split;
}

}  // namespace superray
