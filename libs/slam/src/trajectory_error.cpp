// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/slam/trajectory_error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

namespace superray {
namespace {

using Pose = Eigen::Isometry3d;
using Poses = std::vector<Pose>;

constexpr double kDegreesPerRadian = 180 / M_PI;

Pose asIsometry(const mrpt::poses::CPose3D& pose) {
    Pose T = Pose::Identity();
    T.linear() = pose.getRotationMatrix().asEigen();
    T.translation() = Eigen::Vector3d(pose.x(), pose.y(), pose.z());
    return T;
}

double angleOf(const Pose& T) {
    return std::abs(Eigen::AngleAxisd(Eigen::Quaterniond(T.linear()).normalized()).angle());
}

ErrorSummary summarizeErrors(std::vector<double> errors) {
    ErrorSummary s;
    s.count = errors.size();
    if (errors.empty()) return s;
    const auto n = static_cast<double>(errors.size());
    for (const double e : errors) {
        s.rmse += e * e / n;
        s.mean += e / n;
    }
    s.rmse = std::sqrt(s.rmse);
    std::sort(errors.begin(), errors.end());
    const std::size_t middle = errors.size() / 2;
    s.median = errors.size() % 2 ? errors[middle] : (errors[middle - 1] + errors[middle]) / 2;
    s.maximum = errors.back();
    return s;
}

/// The rigid motion that lays the estimated positions on the true ones.
Pose alignment(const Poses& estimate, const Poses& truth) {
    Eigen::Matrix3Xd from(3, estimate.size()), to(3, truth.size());
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        from.col(static_cast<Eigen::Index>(i)) = estimate[i].translation();
        to.col(static_cast<Eigen::Index>(i)) = truth[i].translation();
    }
    return Pose(Eigen::umeyama(from, to, false));
}

/// Difference of the estimated and the true motion between two poses.
Pose motionError(const Poses& estimate, const Poses& truth, std::size_t i, std::size_t j) {
    return (truth[i].inverse() * truth[j]).inverse() * (estimate[i].inverse() * estimate[j]);
}

std::vector<double> segmentLengths(const TrajectoryErrorOptions& options, double path) {
    for (const double length : options.segmentLengths)
        if (!(std::isfinite(length) && length > 0))
            throw InputError("segment length " + std::to_string(length) + " must be > 0");
    if (!options.segmentLengths.empty()) return options.segmentLengths;
    if (path < 200) return {path / 10, path / 4, path / 2};
    std::vector<double> lengths;
    for (int hundreds = 1; hundreds <= 8 && 100 * hundreds <= path; ++hundreds)
        lengths.push_back(100 * hundreds);
    return lengths;
}

SegmentError segmentError(const Poses& estimate, const Poses& truth,
                          const std::vector<double>& distances, double length) {
    SegmentError result;
    result.length = length;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const auto end =
            std::lower_bound(distances.begin(), distances.end(), distances[i] + length);
        if (end == distances.end()) break;
        const auto j = static_cast<std::size_t>(end - distances.begin());
        if (j == i) continue;
        const Pose error = motionError(estimate, truth, i, j);
        result.translation += error.translation().norm() / length;
        result.rotation += angleOf(error) / length;
        ++result.segments;
    }
    if (result.segments > 0) {
        result.translation /= static_cast<double>(result.segments);
        result.rotation /= static_cast<double>(result.segments);
    }
    return result;
}

std::string centimetres(double metres) {
    std::ostringstream out;
    out << std::fixed << std::setprecision(2) << std::setw(9) << 100 * metres;
    return out.str();
}

std::string degrees(double radians) {
    std::ostringstream out;
    out << std::fixed << std::setprecision(3) << std::setw(9) << radians * kDegreesPerRadian;
    return out.str();
}

using Format = std::string (*)(double);
std::string row(const char* name, const ErrorSummary& s, Format format) {
    return name + format(s.rmse) + format(s.mean) + format(s.median) + format(s.maximum) + "\n";
}

nlohmann::json asJson(const ErrorSummary& s) {
    return {{"rmse", s.rmse},
            {"mean", s.mean},
            {"median", s.median},
            {"max", s.maximum},
            {"count", s.count}};
}

}  // namespace

TrajectoryError compareTrajectories(const Trajectory& estimate, const Trajectory& truth,
                                    const TrajectoryErrorOptions& options) {
    if (options.relativeStep < 1) throw InputError("the relative step must be at least 1 pose");
    TrajectoryError result;
    Poses estimated, actual;
    for (const auto& [time, pose] : estimate.poses()) {
        const auto at = truth.at(time);
        if (!at) {
            ++result.unmatched;
            continue;
        }
        estimated.push_back(asIsometry(pose));
        actual.push_back(asIsometry(*at));
    }
    result.badEstimates = estimate.skippedRows();
    result.badTruths = truth.skippedRows();
    result.poses = actual.size();
    if (result.poses < 3)
        throw InputError("the trajectories have " + std::to_string(result.poses) +
                         " poses at common times; must be at least 3");

    std::vector<double> distances{0};
    for (std::size_t i = 1; i < actual.size(); ++i)
        distances.push_back(distances.back() +
                            (actual[i].translation() - actual[i - 1].translation()).norm());
    result.pathLength = distances.back();

    const Pose T_truth_estimate = alignment(estimated, actual);
    std::vector<double> translations, rotations;
    for (std::size_t i = 0; i < actual.size(); ++i) {
        const Pose aligned = T_truth_estimate * estimated[i];
        translations.push_back((aligned.translation() - actual[i].translation()).norm());
        rotations.push_back(angleOf(actual[i].inverse() * aligned));
    }
    result.absolute = summarizeErrors(translations);
    result.absoluteRotation = summarizeErrors(rotations);

    translations.clear();
    rotations.clear();
    for (std::size_t i = 0; i + options.relativeStep < actual.size(); ++i) {
        const Pose error = motionError(estimated, actual, i, i + options.relativeStep);
        translations.push_back(error.translation().norm());
        rotations.push_back(angleOf(error));
    }
    result.relative = summarizeErrors(translations);
    result.relativeRotation = summarizeErrors(rotations);

    if (result.pathLength > 0)
        for (const double length : segmentLengths(options, result.pathLength))
            result.segments.push_back(segmentError(estimated, actual, distances, length));
    const Pose end = motionError(estimated, actual, 0, actual.size() - 1);
    result.endTranslation = end.translation().norm();
    result.endRotation = angleOf(end);
    return result;
}

std::string describe(const TrajectoryError& e) {
    std::ostringstream out;
    out << std::fixed;
    out << "poses      " << e.poses << " at common times";
    if (e.unmatched > 0) out << ", " << e.unmatched << " estimates outside the true times";
    if (e.badEstimates > 0) out << ", " << e.badEstimates << " estimates not finite";
    if (e.badTruths > 0) out << ", " << e.badTruths << " true poses not finite";
    out << "\npath       " << std::setprecision(3) << e.pathLength << " m\n\n"
        << "                          RMSE     mean   median      max\n"
        << row("ATE, position    [cm]", e.absolute, centimetres)
        << row("ATE, rotation   [deg]", e.absoluteRotation, degrees)
        << row("RPE, translation [cm]", e.relative, centimetres)
        << row("RPE, rotation   [deg]", e.relativeRotation, degrees) << "\n"
        << "segments [m]   translation [%]   rotation [deg/m]   number\n";
    for (const auto& s : e.segments) {
        out << std::setw(12) << std::setprecision(2) << s.length;
        if (s.segments == 0)
            out << "   longer than the path\n";
        else
            out << std::setw(18) << std::setprecision(3) << 100 * s.translation << std::setw(19)
                << std::setprecision(4) << s.rotation * kDegreesPerRadian << std::setw(9)
                << s.segments << "\n";
    }
    out << "\ndrift      " << std::setprecision(3) << 100 * e.drift() << " % of the path ("
        << 100 * e.endTranslation << " cm and " << e.endRotation * kDegreesPerRadian
        << " deg at the end, first poses laid on each other)\n";
    return out.str();
}

std::string describeAsJson(const TrajectoryError& e) {
    nlohmann::json segments = nlohmann::json::array();
    for (const auto& s : e.segments)
        segments.push_back({{"length", s.length},
                            {"translation", s.translation},
                            {"rotation", s.rotation},
                            {"segments", s.segments}});
    const nlohmann::json all = {{"poses", e.poses},
                                {"unmatched", e.unmatched},
                                {"estimates_not_finite", e.badEstimates},
                                {"true_poses_not_finite", e.badTruths},
                                {"path", e.pathLength},
                                {"ate", asJson(e.absolute)},
                                {"ate_rotation", asJson(e.absoluteRotation)},
                                {"rpe", asJson(e.relative)},
                                {"rpe_rotation", asJson(e.relativeRotation)},
                                {"segments", segments},
                                {"end_translation", e.endTranslation},
                                {"end_rotation", e.endRotation},
                                {"drift", e.drift()}};
    return all.dump(2) + "\n";
}

}  // namespace superray
