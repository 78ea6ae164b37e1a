// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file slam_options.h
/// Options of SLAM: public members, .ini sections, validation.

#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/slam/CICP.h>

#include <cstdint>
#include <string>
#include <vector>

namespace superray {

/// From where a scan's registration starts.
enum class MotionPrior : std::uint8_t {
    constantVelocity,  ///< the last motion goes on
    odometry,          ///< the recording's odometry or actions
    none               ///< the last pose
};

/// How scans are aligned with the map. Section `[registration]`.
///
/// The reference is a pyramid of super-ray maps with point statistics. At its
/// first level MRPT's CICP pairs the points with the map (determineMatching3D);
/// then, level by level, Gauss-Newton steps minimise the distances of the points
/// to the surfaces in their cells. CICP alone needs hundreds of iterations for
/// the same, as each of its steps is kept back by the pairs along the surface.
struct TRegistrationOptions : public mrpt::config::CLoadableOptions {
    /// Cell edges of the reference maps, from coarse to fine, comma-separated [m].
    /// Each is about the error that its level can take up.
    std::string resolutions = "1.0, 0.5";
    std::uint32_t decimation = 1;  ///< >= 1; use one of so many measurements
    double minRange = 0;           ///< [m] nearer returns are not used
    double maxRange = 100;         ///< [m] farther returns are not used
    /// [m] One point per cube of this edge is registered: the mean of those in it.
    double pointSpacing = 0.5;
    /// The standard deviation of a range grows with its power of this: 0 for
    /// lidars, 2 for stereo and structured light. Points weigh accordingly.
    double rangeNoiseExponent = 0;
    /// In [0, 1]: surfaces that are less planar do not take part.
    double minPlanarity = 0.3;
    bool icp = true;  ///< MRPT's CICP at the first level, see section [icp]
    /// Steps at each level after that, at most; 0: CICP alone.
    std::uint32_t refinementSteps = 20;
    /// Points farther from the surface are not used, in cells: at first, and at least.
    double gate = 1, smallestGate = 0.2;
    /// [degrees] Turns about the vertical that are tried before, to either side
    /// of prior and last pose; 0: none. For scans that are far apart in angle.
    double yawSearch = 0;
    double yawStep = 4;  ///< [degrees], > 0

    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /// \throws std::invalid_argument naming the option, its value and the rule
    void validate() const;
    /// \throws std::invalid_argument unless > 0 and falling
    std::vector<double> levels() const;
};

/// Which scans become part of the map. Section `[keyframes]`.
struct TKeyFrameOptions : public mrpt::config::CLoadableOptions {
    MotionPrior prior = MotionPrior::constantVelocity;
    /// A scan is inserted after moving so far, or turning so much, since the last
    /// inserted one (names of icp-slam).
    double insertionLinDistance = 1.0;   ///< [m]
    double insertionAngDistance = 15.0;  ///< [degrees]
    /// In [0, 1]: a scan is inserted only if so many of its points are on a surface.
    double minICPgoodness = 0.4;

    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /// \throws std::invalid_argument naming the option, its value and the rule
    void validate() const;
};

/// All options of SLAM but those of the map that is made.
struct TSlamOptions {
    TSlamOptions();

    TRegistrationOptions registration;
    TKeyFrameOptions keyFrames;
    mrpt::slam::CICP::TConfigParams icp;  ///< section `[icp]`, keys as in icp-slam

    /// Reads an .ini file; sections that are not there keep their values.
    /// \throws std::invalid_argument for unknown keys, bad values, or a file
    ///         without any of the sections; InputError if it cannot be read
    void loadFromFile(const std::string& path);
    /// Sections with every option.
    std::string toText() const;
    void validate() const;
};

}  // namespace superray
