// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file CSuperRayPointsMap.h
/// Occupancy maps that are points maps: the occupied cells, for programs that
/// register scans against nothing else (stock icp-slam).

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/mrpt_compat.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

namespace superray {

/// A CSuperRayGridMap whose occupied cells are the points of an MRPT points map.
///
/// Every insertion updates the grid map exactly as it would be updated alone; then
/// there is one point per occupied cell: the mean of the end points that fell in it
/// since it has been occupied [m, map frame], or its centre if there are none (a
/// loaded map). In 2D points have z = 0. Likelihood, 3D view, options and files are
/// those of the grid map; matching is that of the points.
///
/// The points follow the cells. Functions of CPointsMap that change points may be
/// called, but the cells do not follow, and a map whose points were added, removed or
/// moved out of their cells cannot be written to a stream (std::logic_error). Assigning through
/// a CPointsMap& copies the cells, too, or throws std::invalid_argument if the other map is not
/// of this class; from MRPT 2.13.2 on, it clears the cells and copies bare points.
///
/// When memory runs out in an insertion, cells and points are as they were, as in
/// CSuperRayMapBase. Threads: as CSuperRayMapBase.
template <int Dim>
class CSuperRayPointsMap : public AssignablePointsMap {
 public:
    using GridMap = std::conditional_t<Dim == 2, CSuperRayGridMap2D, CSuperRayGridMap3D>;

    const GridMap& occupancy() const;
    /// As SuperRayMapInterface::setOptions().
    void setOptions(const TMapOptions& options);
    /// As SuperRayMapInterface::loadFromFile(): any .srmap of this dimension.
    void loadFromFile(const std::string& path);

    /// Memory of cells and points [bytes]: what TCreationOptions::max_memory_megabytes bounds.
    std::size_t heldBytes() const;

    /// True if no cell is known.
    bool isEmpty() const override;
    std::string asString() const override;
    void getVisualizationInto(mrpt_viz::CSetOfObjects& objects) const override;
    void saveMetricMapRepresentationToFile(const std::string& prefix) const override;
    double internal_computeObservationLikelihood(
        const mrpt::obs::CObservation& observation,
        const mrpt::poses::CPose3D& robotPose) const override;

 protected:
    explicit CSuperRayPointsMap(double resolution);
    ~CSuperRayPointsMap() override;
    CSuperRayPointsMap(const CSuperRayPointsMap& other);
    CSuperRayPointsMap& operator=(const CSuperRayPointsMap& other);

    // For the subclasses' serializeTo / serializeFrom.
    // Version 1: the points are one block of bytes with a checksum.
    static constexpr std::uint8_t kSerialVersion = 1;
    /// \throws std::logic_error if others added, removed or moved points: it could not be
    ///         read; std::invalid_argument for options with which it could not be
    void writeTo(mrpt::serialization::CArchive& out) const;
    /// On any error throws and leaves the map untouched.
    void readFrom(mrpt::serialization::CArchive& in, std::uint8_t version);

 private:
    class Occupancy;
    /// Of each point: its cell, and how many end points it is the mean of.
    struct Source {
        Cell<Dim> cell;
        std::uint32_t ends;
    };
    static constexpr std::uint32_t kNoPoint = ~std::uint32_t{0};
    using BlockPoints = std::array<std::uint32_t, kBlockCells<Dim>>;
    using BlockKeys = std::vector<BlockKey<Dim>>;

    void internal_clear() override;
    bool internal_insertObservation(
        const mrpt::obs::CObservation& observation,
        const std::optional<const mrpt::poses::CPose3D>& robotPose) override;
    bool internal_canComputeObservationLikelihood(
        const mrpt::obs::CObservation& observation) const override;
    /// \throws std::invalid_argument if `other` is not of this class
    void assignFrom(const mrpt::maps::CPointsMap& other) override;

    void copyAll(const CSuperRayPointsMap& other);
    // Of a scan: before it is applied to the cells, which may fail; and afterwards, which
    // does not.
    void prepare(const UpdateBatch<Dim>& batch);
    void prepare(const CellCountMap<Dim>& counts);
    void follow(const RayBundle<Dim>& rays, const BlockKeys& forgotten);
    void makeRoomFor(const typename OccupancyMap<Dim>::WrittenBlocks& written);
    template <class Visit>
    std::size_t forEachNewPoint(const typename OccupancyMap<Dim>::WrittenBlocks& written,
                                const Visit& visit) const;
    void completePoints();
    void forgetBlock(const BlockKey<Dim>& key);
    void forgetLostBlocks();
    // What points take beside the cells [bytes]: those here; at most when so many more
    // cells, in so many more blocks, become occupied; when blocks are written; for other
    // cells.
    std::size_t pointBytes() const;
    std::size_t pointBytesAtMost(std::size_t points, std::size_t blocks) const;
    std::size_t pointBytesWith(const typename OccupancyMap<Dim>::WrittenBlocks& written) const;
    std::size_t pointBytesOf(const OccupancyMap<Dim>& cells, float occupied) const;
    void followBlock(const BlockView<Dim>& block);
    void followAllBlocks();
    void averageEnds(const RayBundle<Dim>& rays);
    void addPoint(const Source& source, const std::array<float, 3>& position);
    void removePoint(std::uint32_t index);
    void forgetPoints();
    template <class Change>
    void remakeOnFailure(const Change& change);
    void readPoint(const Source& source, const std::array<float, 3>& position);
    void requireInCell(const Source& source, const std::array<float, 3>& position) const;
    std::uint32_t& pointAt(const Cell<Dim>& cell);

    std::unique_ptr<Occupancy> occupancy_;
    std::vector<Source> sources_;  // parallel to the points
    std::unordered_map<BlockKey<Dim>, std::unique_ptr<BlockPoints>, IndexHash> blocks_;
    BlockKeys toFollow_;  // when the scan has been applied
};

extern template class CSuperRayPointsMap<2>;
extern template class CSuperRayPointsMap<3>;

/// In .ini files: superRayPointsMap2D_count.
class CSuperRayPointsMap2D : public CSuperRayPointsMap<2> {
    DEFINE_SERIALIZABLE(CSuperRayPointsMap2D, superray)

 public:
    /// \param resolution cell edge [m]
    explicit CSuperRayPointsMap2D(double resolution = 0.10) : CSuperRayPointsMap(resolution) {}

    MAP_DEFINITION_START(CSuperRayPointsMap2D)
    TMapOptions options;
    MAP_DEFINITION_END(CSuperRayPointsMap2D)
};

/// In .ini files: superRayPointsMap3D_count.
class CSuperRayPointsMap3D : public CSuperRayPointsMap<3> {
    DEFINE_SERIALIZABLE(CSuperRayPointsMap3D, superray)

 public:
    /// \param resolution cell edge [m]
    explicit CSuperRayPointsMap3D(double resolution = 0.10) : CSuperRayPointsMap(resolution) {}

    MAP_DEFINITION_START(CSuperRayPointsMap3D)
    TMapOptions options;
    MAP_DEFINITION_END(CSuperRayPointsMap3D)
};

}  // namespace superray
