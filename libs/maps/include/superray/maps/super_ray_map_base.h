// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file super_ray_map_base.h
/// All of the MRPT maps; the classes themselves only add a name and a storage.

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/math/TBoundingBox.h>
#include <superray/core/scan_integrator.h>
#include <superray/maps/change_log.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/nearest_neighbors.h>
#include <superray/maps/options.h>
#include <superray/maps/shared_storage.h>
#include <superray/maps/super_ray_map_interface.h>
#include <superray/maps/surface_statistics.h>
#include <superray/storage/map_file.h>
#include <superray/storage/occupancy_map.h>

#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace superray {

// What exportOctomap() and exportPicture() call.
void writeOctomap(const OccupancyMap<3>& map, const SensorModel& model,
                  const std::string& path);
void writePicture(const OccupancyMap<2>& map, const SensorModel& model,
                  const std::string& path);

template <int Dim>
class VoxelView;
template <int Dim>
class DistanceField;
template <int Dim>
class ObstaclePoints;

/// An occupancy map in MRPT, updated by super rays and culling regions.
///
/// Copies share their cells until one of them changes, so copying is fast.
///
/// The public options may be changed at any time: they are validated and take
/// effect at the next insertion. Errors are std::invalid_argument and leave the
/// map untouched.
///
/// When memory runs out in an insertion (std::bad_alloc), the map is as it was, so that the
/// scan can be inserted again later. (With TInsertionOptions::windowRadius, what the scan
/// puts outside the window may be forgotten already.)
///
/// With a memory bound (TCreationOptions::max_memory_megabytes), a scan, merge, file or
/// stream that would take the map beyond it throws MemoryLimitError before anything changes.
/// With TInsertionOptions::windowRadius, what is far from the sensor is forgotten with each
/// scan.
///
/// Threads: const functions may run beside each other in any number of threads, on one
/// map or on copies of it. A function that is not const, or writing to the public
/// options, needs the map for itself: no other call on *that* map meanwhile. Different
/// maps, copies included, are independent. Observations may be shared by all of them.
template <int Dim>
class CSuperRayMapBase : public mrpt::maps::CMetricMap,
                         public SuperRayMapInterface,
                         public NearestNeighbors {
 public:
    TInsertionOptions insertionOptions;
    TLikelihoodOptions likelihoodOptions;
    TRenderingOptions renderingOptions;

    const OccupancyMap<Dim>& storage() const { return *storage_; }
    MapSummary<Dim> summary() const { return summarize(*storage_, sensorModel()); }
    /// Inserts rays that the caller made. \throws std::invalid_argument if their
    /// geometry has another resolution
    void insertRays(const RayBundle<Dim>& rays);
    /// Where the surface lies in the cells; null if insertionOptions.pointStatistics
    /// was never on. Neither saved nor written to streams.
    const SurfaceStatistics<Dim>* pointStatistics() const { return surface_.get(); }
    /// Calls visit(key) once for each block in which a cell may have become
    /// known or changed its value since changeStamp() was `since`.
    /// \return false, with nothing visited, if the whole map may have changed
    ///         (cleared, loaded, assigned, or changed before the first changeStamp())
    template <class Visit>
    bool forEachChangedBlock(std::uint64_t since, Visit&& visit) const {
        return changes_.forEachSince(since, visit);
    }

    // NearestNeighbors
    std::vector<Neighbor> neighbors(const NeighborQuery& query) const override;

    // SuperRayMapInterface
    int dimension() const override { return Dim; }
    std::string shortClassName() const override;
    double resolution() const override { return storage_->geometry().resolution(); }
    void setResolution(double metres) override;
    CellTotals cellTotals() const override;
    std::optional<MetricBounds> metricBounds() const override;
    std::size_t heldBytes() const override;
    std::size_t memoryBytes() const override {
        return storage_->memoryBytes() + surfaceBytes();
    }
    std::string digest() const override { return contentDigest(*storage_); }
    std::uint64_t changeStamp() const override { return changes_.stamp(); }
    SensorModel sensorModel() const override { return insertionOptions.sensorModel(); }
    std::optional<double> occupancyAt(const Eigen::Vector3d& point) const override;
    bool isOccupied(const Eigen::Vector3d& point) const override;
    std::optional<NearestObstacle> nearestObstacle(const Eigen::Vector3d& point,
                                                   double maxDistance) const override;
    RayCastResult castRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double maxRange, UnknownCells unknown) const override;
    std::optional<float> logOddsAtLevel(const Eigen::Vector3d& point, unsigned level,
                                        LevelRule rule) const override;
    mrpt::maps::CMetricMap::Ptr subMap(const MetricBounds& box) const override;
    void merge(const mrpt::maps::CMetricMap& other,
               const mrpt::poses::CPose3D& T_map_other) override;
    using SuperRayMapInterface::insertObservationAlong;
    bool insertObservationAlong(const mrpt::obs::CObservation& observation,
                                const PoseAtTime& T_map_robot) override;
    const TInsertionReport& lastInsertion() const override { return last_; }
    const TInsertionReport& totals() const override { return totals_; }
    TMapOptions options() const override;
    void setOptions(const TMapOptions& options) override;
    void saveToFile(const std::string& path) const override;
    void loadFromFile(const std::string& path) override;
    void exportPly(const std::string& path) const override;
    void exportScene(const std::string& path) const override;

    /// OctoMap file: .bt (occupied or free only) or .ot (log-odds). 3D maps only.
    /// \throws std::invalid_argument for other extensions
    /// \throws MapFileError if it cannot be written; then an old file is still whole
    template <int D = Dim, std::enable_if_t<D == 3, int> = 0>
    void exportOctomap(const std::string& path) const {
        writeOctomap(*storage_, sensorModel(), path);
    }
    /// Grey picture: occupied black, free white, unknown grey. 2D maps only.
    /// \throws std::invalid_argument for more than 32768 pixels a side
    /// \throws MapFileError if it cannot be written; then an old file is still whole
    template <int D = Dim, std::enable_if_t<D == 2, int> = 0>
    void exportPicture(const std::string& path) const {
        writePicture(*storage_, sensorModel(), path);
    }

    // CMetricMap
    bool isEmpty() const override { return storage_->empty(); }
    std::string asString() const override;
    /// Occupied cells as COctoMapVoxels, which every MRPT viewer knows (in 2D:
    /// cubes on z = 0); empty if genericMapParams.enableSaveAs3DObject is off.
    void getVisualizationInto(mrpt_viz::CSetOfObjects& objects) const override;
    /// Writes PREFIX.srmap and PREFIX.3Dscene, in 3D PREFIX.bt and PREFIX.ot, in 2D
    /// the picture PREFIX.png; each of them whole or not at all.
    /// \throws MapFileError, for a prefix without a file name ("", "out/") before anything
    ///         is written
    void saveMetricMapRepresentationToFile(const std::string& prefix) const override;
    /// Share of the other map's points (it must be, or hold, a points map) that
    /// have an occupied cell within maxDistForCorr; 0 for other maps, and for distances
    /// that are < 0 or NaN.
    float compute3DMatchingRatio(const mrpt::maps::CMetricMap* other,
                                 const mrpt::poses::CPose3D& otherPose,
                                 const mrpt::maps::TMatchingRatioParams& params) const override;
    /// Pairs each point of a points map with the nearest occupied cell: with the
    /// surface in it where insertionOptions.pointStatistics has told where that is
    /// (foot point on the plane of its end points, or their mean), else with its
    /// centre. One pair per point, whatever onlyKeepTheClosest says. As with
    /// CPointsMap, correspondencesRatio is the share of the points asked for that
    /// have a partner, and sumSqrDist the mean of the squared distances. Where the
    /// distance allowed is < 0 or NaN, there are no pairs.
    /// \throws std::invalid_argument if the other map is or holds no points map,
    ///         or the parameters contradict each other
    void determineMatching3D(const mrpt::maps::CMetricMap* other,
                             const mrpt::poses::CPose3D& otherPose,
                             mrpt::tfest::TMatchingPairList& correspondences,
                             const mrpt::maps::TMatchingParams& params,
                             mrpt::maps::TMatchingExtraResults& extraResults) const override;
    void determineMatching2D(const mrpt::maps::CMetricMap* other,
                             const mrpt::poses::CPose2D& otherPose,
                             mrpt::tfest::TMatchingPairList& correspondences,
                             const mrpt::maps::TMatchingParams& params,
                             mrpt::maps::TMatchingExtraResults& extraResults) const override;
    /// [m^2] from (x0, y0), seen from above, to the nearest centre of an occupied cell;
    /// infinite if there is none, or the point is not finite.
    float squareDistanceToClosestCorrespondence(float x0, float y0) const override;
    /// Centres of the occupied cells (2D: z = 0); valid until the map changes.
    using mrpt::maps::CMetricMap::getAsSimplePointsMap;
    const mrpt::maps::CSimplePointsMap* getAsSimplePointsMap() const override;
    mrpt::math::TBoundingBoxf boundingBox() const SUPERRAY_OVERRIDE_SINCE_2_11_3;

 protected:
    CSuperRayMapBase(StorageType type, double resolution);
    ~CSuperRayMapBase() override;
    CSuperRayMapBase(const CSuperRayMapBase& other);
    CSuperRayMapBase& operator=(const CSuperRayMapBase& other);

    // For the subclasses' serializeTo / serializeFrom.
    static constexpr std::uint8_t kSerialVersion = 0;
    void writeTo(mrpt::serialization::CArchive& out) const;
    /// On any error throws and leaves the map untouched.
    void readFrom(mrpt::serialization::CArchive& in, std::uint8_t version);

    using BlockKeys = std::vector<BlockKey<Dim>>;
    using WrittenBlocks = typename OccupancyMap<Dim>::WrittenBlocks;

    // What a subclass keeps beside the cells follows each scan. Called before a scan is
    // applied, and may fail; the cells are as before then:
    virtual void scanToCome(const UpdateBatch<Dim>& /*batch*/) {}
    virtual void scanToCome(const CellCountMap<Dim>& /*counts*/) {}
    /// Called after a scan was applied; must not fail. The blocks that the window has
    /// forgotten have no known cells any more.
    virtual void scanApplied(const RayBundle<Dim>& /*rays*/, const BlockKeys& /*forgotten*/) {}

    /// \throws MemoryLimitError if more is needed [bytes] than a bound allows (0: none)
    void requireWithin(std::uint32_t boundMegabytes, std::size_t needed,
                       const char* what) const;

    // What a subclass keeps beside the cells counts for the memory bound, too [bytes]:
    // now; at most when so many blocks have been written; when these have been; for a map
    // of other cells.
    virtual std::size_t companionBytes() const { return 0; }
    virtual std::size_t companionBytesAtMost(std::size_t /*blocks*/) const { return 0; }
    virtual std::size_t companionBytesWith(const WrittenBlocks& /*written*/) const { return 0; }
    virtual std::size_t companionBytesOf(const OccupancyMap<Dim>& /*cells*/,
                                         float /*occupied*/) const {
        return 0;
    }

 private:
    void internal_clear() override;
    bool internal_insertObservation(
        const mrpt::obs::CObservation& observation,
        const std::optional<const mrpt::poses::CPose3D>& robotPose) override;
    double internal_computeObservationLikelihood(
        const mrpt::obs::CObservation& observation,
        const mrpt::poses::CPose3D& robotPose) const override;
    bool internal_canComputeObservationLikelihood(
        const mrpt::obs::CObservation& observation) const override;

    SharedStorage<Dim> makeEmptyStorage(double resolution) const;
    /// Takes over what was read, with the tighter bound of this one and its own; does
    /// not throw half-way. \throws MemoryLimitError if it is beyond that bound
    void replaceAll(SharedStorage<Dim> storage, TMapOptions options,
                    std::uint32_t boundMegabytes);
    void loadWithin(const std::string& path, std::uint32_t boundMegabytes);
    /// Before a scan is applied: whether it keeps to the memory bound.
    /// \return threads to apply it with  \throws MemoryLimitError
    unsigned requireRoom(const UpdateBatch<Dim>& batch, const RayBundle<Dim>& rays) const;
    void requireRoom(const CellCountMap<Dim>& counts, const RayBundle<Dim>& rays) const;
    void requireRoomFor(const WrittenBlocks& written, std::size_t surfaceBytes,
                        const char* what) const;
    // Memory of the point statistics [bytes]: now; at most with so many cells more; at most
    // with those of a scan.
    std::size_t surfaceBytes() const { return surface_ ? surface_->memoryBytes() : 0; }
    std::size_t surfaceBytesAtMost(std::size_t newCells) const;
    std::size_t surfaceBytesWith(const RayBundle<Dim>& rays) const;
    /// Forgets what is outside of windowRadius. \pre changes_.begin()  \throws std::bad_alloc;
    /// then a part may be forgotten
    BlockKeys slideWindow(const BlockWindow<Dim>& window);
    void assignOptions(const TMapOptions& options);
    /// \return whether it was another, so that there is a new storage, without a reserve
    bool changeResolution(double metres);
    /// Takes the memory that creation.reserve_megabytes asks for.
    void reserveMemory();
    /// All of the contents may be different.
    void contentsChanged();
    // \pre changes_.begin()
    void recordChange(const UpdateBatch<Dim>& batch);
    void recordChange(const CellCountMap<Dim>& counts);
    /// Inserts a scan whose rays toBundle(returns, report) makes.
    template <class ToBundle>
    bool insertReturns(const mrpt::obs::CObservation& observation, ReturnTimes times,
                       ToBundle toBundle);
    /// Statistics that no copy of this map shares.
    SurfaceStatistics<Dim>& makeOwnStatistics();
    /// Whether cells in which a return lies are missed by other rays of the scan.
    enum class HitCells : std::uint8_t { missedToo, notMissed };
    void integrate(const RayBundle<Dim>& rays, TInsertionReport report, HitCells hitCells);
    void applyRays(const RayBundle<Dim>& rays, HitCells hitCells, TInsertionReport& report);
    /// \param change UpdateBatch or CellCountMap
    template <class Change>
    void applyChange(const RayBundle<Dim>& rays, const Change& change, unsigned threads,
                     TInsertionReport& report);
    std::shared_ptr<mrpt_viz::COctoMapVoxels> visualization() const;

    StorageType type_;
    std::uint32_t reserveMegabytes_ = 0, maxMegabytes_ = 0;
    SharedStorage<Dim> storage_;
    std::shared_ptr<SurfaceStatistics<Dim>> surface_;  ///< null: none yet
    ScanIntegrator<Dim> integrator_;
    TInsertionReport last_, totals_;
    ChangeLog<Dim> changes_;
    // Never null; they have their own locks.
    std::unique_ptr<DistanceField<Dim>> distances_;
    std::unique_ptr<ObstaclePoints<Dim>> obstaclePoints_;

    std::unique_ptr<VoxelView<Dim>> view_;
};

extern template class CSuperRayMapBase<2>;
extern template class CSuperRayMapBase<3>;

}  // namespace superray
