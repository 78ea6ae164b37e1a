// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/Lie/SE.h>
#include <superray/eval/input_error.h>
#include <superray/maps/pose_track.h>
#include <superray/slam/range_slam.h>

#include <chrono>
#include <cmath>
#include <future>
#include <stdexcept>

namespace superray {
namespace {

using mrpt::poses::CPose3D;

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A motion at constant velocity over another time.
CPose3D scaled(const CPose3D& motion, double factor) {
    using SE3 = mrpt::poses::Lie::SE<3>;
    auto twist = SE3::log(motion);
    twist *= factor;
    return SE3::exp(twist);
}

double angleOf(const CPose3D& motion) {
    return mrpt::poses::Lie::SE<3>::log(motion).asEigen().tail<3>().norm();
}

}  // namespace

RangeSlam::RangeSlam(const TSlamOptions& options, mrpt::maps::CMetricMap::Ptr map,
                     const CPose3D& T_map_start)
    : options_(options),
      registration_(options.registration, options.icp),
      map_(std::move(map)),
      T_map_robot_(T_map_start) {
    options_.validate();
    if (!map_) throw std::invalid_argument("SLAM needs a map to insert scans into");
}

std::vector<CPose3D> RangeSlam::starts(const Scan& scan) const {
    switch (options_.keyFrames.prior) {
        case MotionPrior::odometry:
            return {T_map_robot_ + (scan.T_map_robot - T_odometry_robot_), T_map_robot_};
        case MotionPrior::constantVelocity: {
            const double now = secondsBetween(lastTime_, scan.timestamp);
            // Unknown, or equal, times: as if scans came at a fixed rate.
            const bool timed = motionSeconds_ > 0 && now > 0;
            // After a gap the old velocity says little.
            const double factor = timed ? std::min(now / motionSeconds_, 2.0) : 1.0;
            return {T_map_robot_ + scaled(motion_, factor), T_map_robot_};
        }
        case MotionPrior::none:
            break;
    }
    return {T_map_robot_};
}

bool RangeSlam::isKeyFrame(const Registration& registration) const {
    const TKeyFrameOptions& o = options_.keyFrames;
    if (registration.goodness < o.minICPgoodness) return false;
    const CPose3D moved = registration.T_map_robot - T_map_keyFrame_;
    return moved.norm() >= o.insertionLinDistance ||
           angleOf(moved) >= o.insertionAngDistance * M_PI / 180;
}

void RangeSlam::insert(const Scan& scan, const SensorReturns& returns,
                       const CPose3D& T_map_robot) {
    // The maps have nothing in common but what they read.
    auto reference =
        std::async(std::launch::async, [&] { registration_.insert(returns, T_map_robot); });
    map_->insertObservation(*scan.observation, T_map_robot);
    reference.get();
    auto pose = mrpt::poses::CPose3DPDFGaussian::Create();
    pose->mean = T_map_robot;
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(scan.observation);
    keyFrames_.insert(pose, frame);
    T_map_keyFrame_ = T_map_robot;
}

std::optional<SlamStep> RangeSlam::process(const Scan& scan) {
    const auto start = std::chrono::steady_clock::now();
    const auto returns =
        readReturns(*scan.observation, {options_.registration.decimation, false, 0});
    if (!returns) return std::nullopt;
    // One plane does not fix six degrees of freedom.
    if (returns->planar)
        throw InputError(
            "a planar scan cannot be registered in 3D: run MRPT's icp-slam with the plugin "
            "(share/config_files/icp-slam-superray.ini), or choose other sensors (--sensor)");
    const RegistrationPoints points = thinOut(*returns, options_.registration);
    if (points.points.empty()) return std::nullopt;
    SlamStep step;
    const bool first = trajectory_.empty();
    if (first) {
        step.registration.T_map_robot = T_map_robot_;
        step.registration.goodness = 1;
    } else {
        step.registration = registration_.align(points, starts(scan));
    }
    const CPose3D T_map_robot = step.registration.T_map_robot;
    step.registrationSeconds = secondsSince(start);
    step.inserted = first || isKeyFrame(step.registration);
    if (step.inserted) insert(scan, *returns, T_map_robot);
    step.insertionSeconds = secondsSince(start) - step.registrationSeconds;

    if (!first) {
        motion_ = T_map_robot - T_map_robot_;
        motionSeconds_ = secondsBetween(lastTime_, scan.timestamp);
    }
    T_map_robot_ = T_map_robot;
    T_odometry_robot_ = scan.T_map_robot;
    lastTime_ = scan.timestamp;
    trajectory_.add(scan.timestamp, T_map_robot);
    return step;
}

SlamReport runSlam(ScanSource& source, RangeSlam& slam, const TSlamOptions& options,
                   const std::function<void(const SlamReport&, const SlamStep&)>& onStep) {
    SlamReport report;
    const auto start = std::chrono::steady_clock::now();
    for (;;) {
        const auto reading = std::chrono::steady_clock::now();
        const auto scan = source.next();
        report.readSeconds += secondsSince(reading);
        if (!scan) break;
        std::optional<SlamStep> step;
        try {
            step = slam.process(*scan);
        } catch (const std::exception& e) {
            throw InputError("scan " + std::to_string(report.scans + report.unusable + 1) +
                             " (sensor '" + scan->observation->sensorLabel +
                             "') cannot be used: " + oneLineCause(e));
        }
        if (!step) {
            ++report.unusable;
            continue;
        }
        ++report.scans;
        report.keyFrames += step->inserted;
        report.weak += step->registration.goodness < options.keyFrames.minICPgoodness;
        report.goodnessSum += step->registration.goodness;
        report.registrationSeconds += step->registrationSeconds;
        report.insertionSeconds += step->insertionSeconds;
        report.totalSeconds = secondsSince(start);
        onStep(report, *step);
    }
    report.skipped = source.skipped();
    report.warning = source.warning();
    report.totalSeconds = secondsSince(start);
    if (report.scans == 0)
        throw InputError("none of the " + std::to_string(report.unusable) +
                         " scans has ranges or points within minRange and maxRange");
    return report;
}

}  // namespace superray
