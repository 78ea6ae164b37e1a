// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scan_registration.h
/// Where was the robot when it took this scan?

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/observation_rays.h>
#include <superray/slam/slam_options.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace superray {

/// A scan, thinned out for registration.
struct RegistrationPoints {
    std::vector<Eigen::Vector3d> points;  ///< [m, robot frame]
    std::vector<double> weights;          ///< relative inverse variances
};

/// The returns of a scan that take part, averaged over cubes of pointSpacing.
RegistrationPoints thinOut(const SensorReturns& returns, const TRegistrationOptions& options);

struct Registration {
    mrpt::poses::CPose3D T_map_robot;
    /// Share of the points within the last gate of a surface, in [0, 1].
    double goodness = 0;
    double residual = 0;         ///< RMS distance of those to their surface [m]
    unsigned icpIterations = 0;  ///< of CICP
    unsigned refinementSteps = 0;
};

/// Scans against a pyramid of super-ray maps; see TRegistrationOptions.
class ScanRegistration {
 public:
    /// \throws std::invalid_argument for invalid options
    ScanRegistration(const TRegistrationOptions& options,
                     const mrpt::slam::CICP::TConfigParams& icp);

    /// Makes a scan part of the reference.
    void insert(const SensorReturns& returns, const mrpt::poses::CPose3D& T_map_robot);

    /// Aligns a scan, starting from the poses that are given (the best of them
    /// and, with yawSearch, of their turns). \pre !starts.empty(), !empty()
    Registration align(const RegistrationPoints& scan,
                       const std::vector<mrpt::poses::CPose3D>& starts) const;

    bool empty() const { return levels_.front().isEmpty(); }
    const std::vector<CSuperRayGridMap3D>& levels() const { return levels_; }

 private:
    struct Fit;
    mrpt::poses::CPose3D bestStart(const RegistrationPoints& scan,
                                   const std::vector<mrpt::poses::CPose3D>& starts) const;
    void alignByIcp(const RegistrationPoints& scan, Registration& result) const;
    void refine(const RegistrationPoints& scan, const CSuperRayGridMap3D& level,
                Registration& result) const;

    TRegistrationOptions options_;
    mrpt::slam::CICP::TConfigParams icpOptions_;
    std::vector<CSuperRayGridMap3D> levels_;  ///< coarse to fine
};

}  // namespace superray
