// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <superray/slam/scan_registration.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace superray {
namespace {

using mrpt::poses::CPose3D;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kDegrees = M_PI / 180;

/// Fewer matched points do not fix six degrees of freedom.
constexpr std::size_t kFewestPoints = 20;

Eigen::Isometry3d asIsometry(const CPose3D& pose) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = pose.getRotationMatrix().asEigen();
    T.translation() = Eigen::Vector3d(pose.x(), pose.y(), pose.z());
    return T;
}

CPose3D asPose(const Eigen::Isometry3d& T) {
    // By the quaternion: products of rotation matrices slowly stop being rotations.
    const Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
    const Eigen::Vector3d t = T.translation();
    return CPose3D(mrpt::math::CQuaternionDouble(q.w(), q.x(), q.y(), q.z()), t.x(), t.y(),
                   t.z());
}

/// The surface in the cell of a point, if that is occupied and planar enough.
class SurfaceLookup {
 public:
    SurfaceLookup(const CSuperRayGridMap3D& map, double minPlanarity)
        : storage_(map.storage()),
          statistics_(*map.pointStatistics()),
          occupied_(map.sensorModel().occupied()),
          minPlanarity_(minPlanarity) {}

    const SurfacePatch<3>* operator()(const Eigen::Vector3d& p) const {
        if (!storage_.geometry().contains(p)) return nullptr;
        const Cell<3> cell = storage_.geometry().cellOf(p);
        const auto* patch = statistics_.patch(cell);
        if (!patch || patch->planarity < minPlanarity_ || patch->planarity <= 0) return nullptr;
        const auto value = storage_.logOdds(cell);
        return value && *value >= occupied_ ? patch : nullptr;
    }

 private:
    const OccupancyMap<3>& storage_;
    const SurfaceStatistics<3>& statistics_;
    float occupied_;
    double minPlanarity_;
};

/// How much a residual counts: 1 at 0, half at about 0.64 scale (Geman-McClure).
double robustWeight(double residual, double scale) {
    const double ratio = residual / scale;
    const double w = 1 / (1 + ratio * ratio);
    return w * w;
}

TMapOptions levelOptions(double resolution, const TRegistrationOptions& options) {
    TMapOptions o;
    o.creation.resolution = resolution;
    o.insertion.pointStatistics = true;
    // Else rays along the ground would clear it.
    o.insertion.setPolicy(UpdatePolicy::oncePerScan);
    o.insertion.minrange = options.minRange;
    o.insertion.maxrange = options.maxRange;
    return o;
}

}  // namespace

RegistrationPoints thinOut(const SensorReturns& returns, const TRegistrationOptions& options) {
    const Eigen::Isometry3d T_robot_sensor = asIsometry(returns.sensorOnRobot);
    const CellGeometry<3> cubes(options.pointSpacing);
    struct Sum {
        Eigen::Vector3d points = Eigen::Vector3d::Zero();
        double count = 0;
    };
    std::unordered_map<Cell<3>, std::size_t, IndexHash> numbers;
    std::vector<Sum> sums;
    for (const auto& hit : returns.hits) {
        const Eigen::Vector3d p_sensor = hit.cast<double>();
        const double range = p_sensor.norm();
        // Written so that NaN fails.
        if (!(range >= options.minRange && range <= options.maxRange)) continue;
        const Eigen::Vector3d p = T_robot_sensor * p_sensor;
        if (!cubes.contains(p)) continue;
        const auto [entry, isNew] = numbers.emplace(cubes.cellOf(p), sums.size());
        if (isNew) sums.emplace_back();
        sums[entry->second].points += p;
        ++sums[entry->second].count;
    }
    RegistrationPoints result;
    for (const Sum& sum : sums) {
        result.points.push_back(sum.points / sum.count);
        const double range =
            std::max(0.01, (result.points.back() - T_robot_sensor.translation()).norm());
        result.weights.push_back(std::pow(range, -2 * options.rangeNoiseExponent));
    }
    return result;
}

ScanRegistration::ScanRegistration(const TRegistrationOptions& options,
                                   const mrpt::slam::CICP::TConfigParams& icp)
    : options_(options), icpOptions_(icp) {
    options_.validate();
    for (const double resolution : options_.levels()) {
        levels_.emplace_back(resolution);
        levels_.back().setOptions(levelOptions(resolution, options_));
    }
}

void ScanRegistration::insert(const SensorReturns& returns, const CPose3D& T_map_robot) {
    for (auto& level : levels_) {
        TInsertionReport ignored;
        level.insertRays(toRays<3>(returns, T_map_robot, level.storage().geometry(),
                                   level.insertionOptions, ignored));
    }
}

Registration ScanRegistration::align(const RegistrationPoints& scan,
                                     const std::vector<CPose3D>& starts) const {
    Registration result;
    result.T_map_robot = bestStart(scan, starts);
    if (scan.points.empty()) return result;
    if (options_.icp) alignByIcp(scan, result);
    if (options_.refinementSteps > 0)
        for (const auto& level : levels_) refine(scan, level, result);
    return result;
}

CPose3D ScanRegistration::bestStart(const RegistrationPoints& scan,
                                    const std::vector<CPose3D>& starts) const {
    if (options_.yawSearch <= 0) return starts.front();
    constexpr std::size_t kPoints = 1000;  // enough to tell turns apart
    const SurfaceLookup surfaceAt(levels_.front(), options_.minPlanarity);
    const double scale = options_.smallestGate * levels_.front().resolution();
    const std::size_t step = std::max<std::size_t>(1, scan.points.size() / kPoints);
    const auto score = [&](const Eigen::Isometry3d& T) {
        double sum = 0;
        for (std::size_t i = 0; i < scan.points.size(); i += step) {
            const Eigen::Vector3d p = T * scan.points[i];
            if (const auto* patch = surfaceAt(p))
                sum += robustWeight(patch->normal.dot(p - patch->mean), scale);
        }
        return sum;
    };
    Eigen::Isometry3d best = asIsometry(starts.front());
    double bestScore = score(best);
    const int turns = static_cast<int>(std::floor(options_.yawSearch / options_.yawStep));
    for (const CPose3D& start : starts) {
        for (int turn = -turns; turn <= turns; ++turn) {
            Eigen::Isometry3d T = asIsometry(start);
            T.linear() = Eigen::AngleAxisd(turn * options_.yawStep * kDegrees,
                                           Eigen::Vector3d::UnitZ()) *
                         T.linear();
            const double s = score(T);
            if (s <= bestScore) continue;
            bestScore = s;
            best = T;
        }
    }
    return asPose(best);
}

void ScanRegistration::alignByIcp(const RegistrationPoints& scan, Registration& result) const {
    // CICP's closed-form step also estimates a scale and throws it away. Around
    // the centre of the points that does no harm to the translation.
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const auto& p : scan.points) centre += p;
    centre /= static_cast<double>(scan.points.size());
    mrpt::maps::CSimplePointsMap points;
    points.reserve(scan.points.size());
    for (const auto& p : scan.points) {
        const Eigen::Vector3f q = (p - centre).cast<float>();
        points.insertPointFast(q.x(), q.y(), q.z());
    }
    points.mark_as_modified();
    const CPose3D T_robot_centre(centre.x(), centre.y(), centre.z(), 0, 0, 0);
    mrpt::slam::CICP icp(icpOptions_);
    mrpt::slam::CICP::TReturnInfo info;
    const auto found = icp.Align3DPDF(
        &levels_.front(), &points,
        mrpt::poses::CPose3DPDFGaussian(result.T_map_robot + T_robot_centre), info);
    result.T_map_robot = found->getMeanVal() + (CPose3D() - T_robot_centre);
    result.icpIterations = info.nIterations;
    result.goodness = info.goodness;
}

/// The normal equations of one step.
struct ScanRegistration::Fit {
    Matrix6 A = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    std::size_t used = 0;
    double squares = 0;
};

void ScanRegistration::refine(const RegistrationPoints& scan, const CSuperRayGridMap3D& level,
                              Registration& result) const {
    constexpr double kShrink = 0.8;  // of the gate, per step
    const SurfaceLookup surfaceAt(level, options_.minPlanarity);
    const double cell = level.resolution();
    double gate = options_.gate * cell;
    Eigen::Isometry3d T = asIsometry(result.T_map_robot);
    for (std::uint32_t step = 0; step < options_.refinementSteps; ++step) {
        Fit fit;
        for (std::size_t i = 0; i < scan.points.size(); ++i) {
            const Eigen::Vector3d p = T * scan.points[i];
            const auto* patch = surfaceAt(p);
            if (!patch) continue;
            const double e = patch->normal.dot(p - patch->mean);
            if (std::abs(e) > gate) continue;
            const double w = robustWeight(e, gate / 2) * patch->planarity * scan.weights[i];
            // Rotations are about the robot: small numbers, far from the origin too.
            Vector6 J;
            J << patch->normal, (p - T.translation()).cross(patch->normal);
            fit.A += w * J * J.transpose();
            fit.b -= w * e * J;
            ++fit.used;
            fit.squares += e * e;
        }
        if (fit.used < kFewestPoints) {
            result.goodness = 0;
            return;
        }
        result.goodness =
            static_cast<double>(fit.used) / static_cast<double>(scan.points.size());
        result.residual = std::sqrt(fit.squares / static_cast<double>(fit.used));
        // What the surfaces leave open (along a corridor) stays as it is.
        fit.A.diagonal().array() += 1e-9 * fit.A.trace();
        const Vector6 d = fit.A.ldlt().solve(fit.b);
        if (!d.allFinite()) return;
        const Eigen::Vector3d turn = d.tail<3>();
        const double angle = turn.norm();
        if (angle > 0) T.linear() = Eigen::AngleAxisd(angle, turn / angle) * T.linear();
        T.translation() += d.head<3>();
        result.T_map_robot = asPose(T);
        T = asIsometry(result.T_map_robot);
        ++result.refinementSteps;
        gate = std::max(gate * kShrink, options_.smallestGate * cell);
        if (d.head<3>().norm() < 2e-4 * cell && angle < 1e-5) return;
    }
}

}  // namespace superray
