// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file super_ray_map_interface.h
/// The maps for code that does not know their dimension: dynamic_cast a
/// CMetricMap to this. What only 2D or only 3D maps can do is in CSuperRayMapBase.

#include <mrpt/maps/CMetricMap.h>
#include <superray/core/sensor_model.h>
#include <superray/maps/insertion_report.h>
#include <superray/maps/map_queries.h>
#include <superray/maps/observation_rays.h>
#include <superray/maps/options.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

namespace mrpt::poses {
class CPose3DInterpolator;
}

namespace superray {

class SuperRayMapInterface {
 public:
    virtual ~SuperRayMapInterface() = default;

    virtual int dimension() const = 0;
    /// E.g. "CSuperRayGridMap3D".
    virtual std::string shortClassName() const = 0;
    virtual double resolution() const = 0;  ///< [m]
    /// \throws std::logic_error if the map is not empty
    /// \throws std::invalid_argument unless isResolution()
    virtual void setResolution(double metres) = 0;

    virtual CellTotals cellTotals() const = 0;
    /// Box around the known cells; nothing if there are none.
    virtual std::optional<MetricBounds> metricBounds() const = 0;
    virtual std::size_t memoryBytes() const = 0;
    /// Memory [bytes] that TCreationOptions::max_memory_megabytes bounds: that of the cells,
    /// what is free for cells to come included, of the point statistics, and of what a
    /// points map keeps per cell.
    virtual std::size_t heldBytes() const = 0;
    /// Digest of the contents; see contentDigest().
    virtual std::string digest() const = 0;
    virtual SensorModel sensorModel() const = 0;
    /// A number that grows with every change of the contents; see
    /// CSuperRayMapBase::forEachChangedBlock().
    virtual std::uint64_t changeStamp() const = 0;

    /// Probability, in (0, 1), that the cell around a point is occupied; nothing if the
    /// cell is unknown or cannot be addressed. Safe to call concurrently.
    /// \param point [m, map frame]; 2D maps ignore z
    virtual std::optional<double> occupancyAt(const Eigen::Vector3d& point) const = 0;
    /// Whether the cell around a point is known and its probability is at least
    /// insertionOptions.occupancyThres. False for unknown cells; ask occupancyAt() to
    /// tell free from unknown. Safe to call concurrently.
    /// \param point [m, map frame]; 2D maps ignore z
    virtual bool isOccupied(const Eigen::Vector3d& point) const = 0;
    /// The occupied cell nearest to a point (by the centres of cells), if its box is
    /// within maxDistance [m], which may be infinite. Up to about 30 cells the answer
    /// comes from a distance field and takes constant time once that is up to date.
    /// The point may lie outside the addressable range; of one that is not finite, or
    /// farther than 1e150 m from the origin, there is no answer.
    /// Safe to call concurrently. \throws std::invalid_argument if maxDistance < 0
    virtual std::optional<NearestObstacle> nearestObstacle(const Eigen::Vector3d& point,
                                                           double maxDistance) const = 0;
    /// What a ray meets, walking over the cells that an inserted ray would touch. 2D
    /// maps take the first two coordinates.
    /// \param maxRange [m], > 0; may be infinite
    /// \throws std::invalid_argument for an origin outside the addressable range, a
    ///         direction that is not finite or of length 0, a range that is not > 0
    virtual RayCastResult castRay(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction, double maxRange,
                                  UnknownCells unknown) const = 0;
    /// Log-odds of the aligned cube of 2^level cells per axis around a point (level 0:
    /// its cell; depth 16 - level in OctoMap's terms); nothing if all is unknown.
    /// Needs no tree. \throws std::invalid_argument if level > 16
    virtual std::optional<float> logOddsAtLevel(const Eigen::Vector3d& point, unsigned level,
                                                LevelRule rule) const = 0;
    /// A map of the same class and options with the cells whose centres are in the
    /// box. \throws std::invalid_argument unless box.lowest <= box.highest
    virtual mrpt::maps::CMetricMap::Ptr subMap(const MetricBounds& box) const = 0;
    /// Adds the log-odds of another map, clamped by this map's sensor model; unknown
    /// cells add nothing. Each cell takes the value of the other's cell that its centre
    /// lies in, so a shift by whole cells is exact. The maps may differ in resolution
    /// and storage. \throws std::invalid_argument, and changes nothing, if the other is
    ///         not of this library and dimension, cells would not be addressable, or
    ///         (2D) the pose is not planar
    /// \throws MemoryLimitError, likewise, if it would pass the bound, or take more memory
    ///         for itself than MapFileLimits::ofThisMachine() allows
    virtual void merge(const mrpt::maps::CMetricMap& other,
                       const mrpt::poses::CPose3D& T_map_other) = 0;

    /// Inserts a scan that was taken while the robot moved: each ray from where the
    /// sensor was when it was measured (Velodyne packets: the time of each firing;
    /// 2D and single-row rotating scans: insertionOptions.sweepDuration; else all at
    /// the observation's time stamp). Rays of times without a pose, or whose
    /// pose is not finite, are left out and counted. Depends on
    /// genericMapParams.enableObservationInsertion as CMetricMap::insertObservation() does.
    /// \return true if the map changed
    virtual bool insertObservationAlong(const mrpt::obs::CObservation& observation,
                                        const PoseAtTime& T_map_robot) = 0;
    /// With the robot's trajectory in the map frame: straight between its poses, over at
    /// most the trajectory's own limit of time if it has one, else kDefaultPoseGap.
    bool insertObservationAlong(const mrpt::obs::CObservation& observation,
                                const mrpt::poses::CPose3DInterpolator& trajectory);

    /// What the last insertion did, and the sum of all since construction,
    /// clear() or loading.
    virtual const TInsertionReport& lastInsertion() const = 0;
    virtual const TInsertionReport& totals() const = 0;

    /// All options (a copy; `creation` holds the resolution, the reserve and the
    /// generic parameters that are in force).
    virtual TMapOptions options() const = 0;
    /// Replaces all options. With load_from, the contents and the resolution of
    /// that file too; else the resolution may change only while the map is empty.
    /// \throws std::invalid_argument, std::logic_error, MapFileError
    virtual void setOptions(const TMapOptions& options) = 0;
    /// Reads the sections `<prefix>_creationOpts`, `<prefix>_insertOpts`, ...;
    /// what they do not name is kept. \throws as setOptions()
    void setOptionsFromConfig(const mrpt::config::CConfigFileBase& source,
                              const std::string& prefix) {
        TMapOptions updated = options();
        updated.loadFromConfigFile(source, prefix);
        setOptions(updated);
    }
    /// .ini text of all options: sections [creationOpts], [insertOpts], ...
    std::string optionsAsIniText() const { return options().toText(); }

    /// Native file (.srmap), contents and options. \throws MapFileError
    virtual void saveToFile(const std::string& path) const = 0;
    /// Replaces contents and options; on error the map stays as it is. A map
    /// of the other storage type but the same dimension is accepted.
    /// \throws MapFileError
    virtual void loadFromFile(const std::string& path) = 0;

    /// Binary PLY: centres of occupied cells and their probability.
    /// \throws MapFileError if it cannot be written; then an old file is still whole
    virtual void exportPly(const std::string& path) const = 0;
    /// MRPT scene with the map's visualisation, whatever enableSaveAs3DObject is.
    /// \throws MapFileError if it cannot be written; then an old file is still whole
    virtual void exportScene(const std::string& path) const = 0;
};

}  // namespace superray
