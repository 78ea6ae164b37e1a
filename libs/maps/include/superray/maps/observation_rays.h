#pragma once
/// \file observation_rays.h
/// MRPT observations to rays. Robot pose and sensor pose act on origin and
/// points alike.
///
/// | observation              | what is read                                        |
/// |--------------------------|-----------------------------------------------------|
/// | CObservation3DRangeScan  | range image (pinhole or fisheye, distortion undone);|
/// |                          | points3D when there is none                         |
/// | CObservationVelodyneScan | raw packets, every return; point_cloud without them |
/// | CObservationPointCloud   | the cloud (sensor frame)                            |
/// | CObservation2DRangeScan  | valid ranges (a deltaPitch sweep is not modelled)   |
/// | CObservationRotatingScan | points where the MRPT version has them; else the    |
/// |                          | range image if it has one row (no vertical angles)  |

#include <mrpt/obs/obs_frwds.h>
#include <mrpt/poses/CPose3D.h>
#include <superray/core/ray_bundle.h>
#include <superray/maps/insertion_report.h>
#include <superray/maps/options.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace superray {

/// What to take from an observation.
struct ReturnOptions {
    unsigned decimation = 1;    ///< use one of so many measurements
    bool noReturnRays = false;  ///< also list measurements without a return
    double noReturnRange = 0;   ///< [m] their length; <= 0: the sensor's maximum range
};

/// A scan in the sensor's frame.
struct SensorReturns {
    mrpt::poses::CPose3D sensorOnRobot;
    std::vector<Eigen::Vector3f> hits;       ///< [m]
    std::vector<Eigen::Vector3f> noReturns;  ///< far ends of rays without return [m]
    std::uint64_t noReturnCount = 0;  ///< measurements without (valid) return, listed or not
    bool planar = false;              ///< a 2D scan: the height band does not apply
};

/// True if readReturns() knows the class and finds ranges or points in it.
/// (Externally stored ones are assumed to have them.)
bool canReadReturns(const mrpt::obs::CObservation& observation);

/// Reads a scan. Externally stored data are loaded, and unloaded again if they
/// were not loaded before; otherwise the observation stays as it is.
/// \return nothing if the observation has no ranges or points we can use
/// \throws std::exception if its data contradict each other or cannot be loaded
std::optional<SensorReturns> readReturns(const mrpt::obs::CObservation& observation,
                                         const ReturnOptions& options);

/// A scan in the map frame. In 2D the rays are projected on z = 0, so range
/// limits act on their horizontal length.
/// \param report skipped, noReturns, outOfHeightBand are added to
/// \throws std::invalid_argument if the sensor is not in the addressable range
template <int Dim>
RayBundle<Dim> toRays(const SensorReturns& returns, const mrpt::poses::CPose3D& T_map_robot,
                      const CellGeometry<Dim>& geometry, const TInsertionOptions& options,
                      TInsertionReport& report);

}  // namespace superray
