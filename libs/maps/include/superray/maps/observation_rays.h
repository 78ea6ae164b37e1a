// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file observation_rays.h
/// MRPT observations to rays. Robot pose and sensor pose act on origin and
/// points alike.
///
/// | observation              | what is read                                        |
/// |--------------------------|-----------------------------------------------------|
/// | CObservation3DRangeScan  | range image (pinhole or fisheye, distortion undone);|
/// |                          | points3D when there is none                         |
/// | CObservationVelodyneScan | raw packets, every return, each with its time;       |
/// |                          | point_cloud without them                            |
/// | CObservationPointCloud   | the cloud (sensor frame), each point with its time  |
/// |                          | where the MRPT version and the cloud have it         |
/// | CObservation2DRangeScan  | valid ranges (a deltaPitch sweep is not modelled);  |
/// |                          | a valid range of 0 tells nothing                    |
/// | CObservationRotatingScan | points where the MRPT version has them; else the    |
/// |                          | range image if it has one row (no vertical angles)  |
///
/// Of every sensor, what is beyond its own maximum range (where it has one) is no return.

#include <mrpt/core/Clock.h>
#include <mrpt/obs/obs_frwds.h>
#include <mrpt/poses/CPose3D.h>
#include <superray/core/ray_bundle.h>
#include <superray/maps/insertion_report.h>
#include <superray/maps/options.h>

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace superray {

/// Whether the time of each measurement is wanted.
enum class ReturnTimes : std::uint8_t { ignore, read };

/// What to take from an observation.
struct ReturnOptions {
    unsigned decimation = 1;    ///< use one of so many measurements
    bool noReturnRays = false;  ///< also list measurements without a return
    double noReturnRange = 0;   ///< [m] their length; <= 0: the sensor's maximum range
    ReturnTimes times = ReturnTimes::ignore;
    double sweepSeconds = 0;  ///< [s] from the first ray of a planar scan to its last
};

/// A scan in the sensor's frame.
struct SensorReturns {
    mrpt::poses::CPose3D sensorOnRobot;
    std::vector<Eigen::Vector3f> hits;       ///< [m]
    std::vector<Eigen::Vector3f> noReturns;  ///< far ends of rays without return [m]
    /// With ReturnTimes::read, when each hit and noReturn was measured: [s] after
    /// the observation's time stamp (< 0: before it), 0 where the sensor does not
    /// tell. Points with times that are no numbers have no pose.
    std::vector<float> hitTimes, noReturnTimes;
    std::uint64_t noReturnCount = 0;  ///< measurements without (valid) return, listed or not
    bool planar = false;              ///< a 2D scan
};

/// True if readReturns() knows the class and finds ranges or points in it.
/// (Externally stored ones are assumed to have them.)
bool canReadReturns(const mrpt::obs::CObservation& observation);

/// Reads a scan. Externally stored data are loaded, and unloaded again if they
/// were not loaded before; otherwise the observation stays as it is.
/// \return nothing if the observation has no ranges or points we can use
/// \throws std::exception if its data contradict each other or cannot be loaded;
///         std::invalid_argument for an aperture that is not from 0 to 2 pi, a start of
///         azimuths that is not finite, or a span of them beyond 2 pi
std::optional<SensorReturns> readReturns(const mrpt::obs::CObservation& observation,
                                         const ReturnOptions& options);

/// Why readReturns() finds nothing in an observation that has data; else empty.
std::string whyUnreadable(const mrpt::obs::CObservation& observation);

/// A scan in the map frame. In 2D the rays are projected on z = 0, so range
/// limits act on their horizontal length, and what a 3D sensor's ray crosses outside the
/// height band is cut away. The bundle has no limits of its own then.
/// \param report skipped, noReturns, outOfHeightBand, tilted are added to
/// \throws std::invalid_argument if the sensor is not in the addressable range
template <int Dim>
RayBundle<Dim> toRays(const SensorReturns& returns, const mrpt::poses::CPose3D& T_map_robot,
                      const CellGeometry<Dim>& geometry, const TInsertionOptions& options,
                      TInsertionReport& report);

/// Robot pose in the map frame at a time; nothing where it is not known. One that is not
/// finite counts as not known.
using PoseAtTime = std::function<std::optional<mrpt::poses::CPose3D>(mrpt::Clock::time_point)>;

/// The same for a robot that moves during the scan: each ray has the pose, and the
/// origin, of its own time. Rays without a pose are left out and counted.
/// \param timestamp of the observation
/// \param returns read with ReturnTimes::read
/// \throws std::invalid_argument if the sensor is not in the addressable range at the first
///         measurement that has a pose
template <int Dim>
RayBundle<Dim> toRaysAlong(const SensorReturns& returns, mrpt::Clock::time_point timestamp,
                           const PoseAtTime& T_map_robot, const CellGeometry<Dim>& geometry,
                           const TInsertionOptions& options, TInsertionReport& report);

}  // namespace superray
