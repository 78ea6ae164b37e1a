// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file occupancy_map.h
/// What every map storage does, for 2D and 3D alike.

#include <superray/core/block.h>
#include <superray/core/cell_counts.h>
#include <superray/core/saturation_source.h>
#include <superray/core/sensor_model.h>
#include <superray/core/update_batch.h>
#include <superray/storage/block_window.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace superray {

/// Contents of one block: `values[i]` is the log-odds of cell index i where
/// `known` has bit i; other values are unspecified.
template <int Dim>
struct BlockView {
    BlockKey<Dim> key;
    const float* values;  ///< kBlockCells<Dim> of them
    BlockMask<Dim> known;
};

/// Log-odds per cell. Unknown is a state of its own, not a value.
///
/// Not thread-safe for writing; const members may be called concurrently.
template <int Dim>
class OccupancyMap : public SaturationSource<Dim> {
 public:
    using BlockVisitor = std::function<void(const BlockView<Dim>&)>;
    using KeyVisitor = std::function<void(const BlockKey<Dim>&)>;
    /// Calls a visitor with each block that is to be written, once: `known` are the cells
    /// to be written, `values` their values to come.
    using WrittenBlocks = std::function<void(const BlockVisitor&)>;

    explicit OccupancyMap(const CellGeometry<Dim>& geometry) : geometry_(geometry) {}

    const CellGeometry<Dim>& geometry() const { return geometry_; }

    /// A deep copy.
    virtual std::unique_ptr<OccupancyMap> clone() const = 0;
    /// An empty map of the same type.
    virtual std::unique_ptr<OccupancyMap> emptyLike(
        const CellGeometry<Dim>& geometry) const = 0;

    /// Exchanges the contents with a map of the same type.
    /// \throws std::bad_cast if the types differ, std::invalid_argument if the
    /// resolutions differ
    virtual void swapContents(OccupancyMap& other) = 0;

    /// Applies a scan (design rules 4 and 5): for every touched cell
    /// value = model.updated(value or 0, misses, hits, policy), bit for bit.
    /// \param threads at most so many; the result does not depend on it
    /// \throws std::out_of_range if a block is not addressable (kCellLimit), std::bad_alloc,
    /// std::length_error (more blocks or nodes than a map can have); nothing is applied then
    virtual void apply(const UpdateBatch<Dim>& batch, const SensorModel& model,
                       UpdatePolicy policy, unsigned threads) = 0;
    void apply(const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy) {
        apply(batch, model, policy, 1);
    }

    /// The same from exact counts, cell by cell (method `reference`). \throws likewise
    void apply(const CellCountMap<Dim>& counts, const SensorModel& model, UpdatePolicy policy);

    /// Log-odds of a cell; nothing if unknown.
    virtual std::optional<float> logOdds(const Cell<Dim>& cell) const = 0;
    /// Bounds of all values that the map has had since it was made, cleared or exchanged.
    LogOddsRange valueRange() const final { return range_; }
    /// Makes a cell known with this value (-0 is stored as +0, so that equal
    /// values have equal bits).
    /// \throws std::out_of_range if the cell is not addressable (kCellLimit),
    /// std::invalid_argument if the value is not finite
    virtual void setLogOdds(const Cell<Dim>& cell, float value) = 0;
    /// Sets the cells that `block` knows and leaves the others alone (loading a
    /// file, merging). \throws as setLogOdds(), and changes nothing then
    virtual void setBlock(const BlockView<Dim>& block) = 0;
    /// The same for many blocks, each once: all, or none.
    /// \param written visits the same blocks each time; it is asked several times
    /// \throws as setLogOdds(), std::bad_alloc, std::length_error (more blocks or nodes than
    /// a map can have), and changes nothing then
    void setBlocks(const WrittenBlocks& written);

    /// Visits every block with a known cell, in unspecified order. Uniform
    /// regions of trees are visited block by block, at full resolution.
    virtual void forEachBlock(const BlockVisitor& visit) const = 0;
    /// Visits one block, as forEachBlock() does. \return whether it has a known cell
    virtual bool visitBlock(const BlockKey<Dim>& key, const BlockVisitor& visit) const = 0;

    virtual void clear() = 0;
    virtual bool empty() const = 0;
    /// Takes memory from the system for contents to come, and touches it, so that updates
    /// need not wait for page faults: about so many bytes, less what is at hand already.
    /// It counts as held. clear() gives it back, and clones do not get it.
    /// \throws std::bad_alloc, std::length_error (more blocks or nodes than a map can
    /// have), and leaves the contents as they are
    virtual void reserve(std::size_t bytes) = 0;
    /// Bytes held by the contents (allocator overhead included as far as known).
    virtual std::size_t memoryBytes() const = 0;

    // --- sliding window and memory bound ------------------------------------
    /// Makes the cells of all blocks outside a window unknown. Their memory is used again
    /// by blocks to come. Takes the time of what is at the border of the window or beyond.
    /// \param forgotten called with each block that had a known cell, after it is gone; in
    ///        unspecified order
    /// \throws std::bad_alloc; then each block is whole or gone
    virtual void forgetOutside(const BlockWindow<Dim>& window, const KeyVisitor& forgotten) = 0;

    /// Bytes taken from the system, those that are free for blocks to come included. Takes
    /// constant time.
    virtual std::size_t heldBytes() const = 0;
    /// The most that heldBytes() can be after an update that writes to so many blocks.
    virtual std::size_t heldBytesAtMost(std::size_t blocks, unsigned threads) const = 0;
    /// The most that heldBytes() can be after blocks are written by one thread. Looks at the
    /// blocks, so it is closer than heldBytesAtMost().
    virtual std::size_t heldBytesWith(const WrittenBlocks& written) const = 0;
    /// What apply() would write.
    void forEachWritten(const UpdateBatch<Dim>& batch, const SensorModel& model,
                        UpdatePolicy policy, const BlockVisitor& visit) const;
    void forEachWritten(const CellCountMap<Dim>& counts, const SensorModel& model,
                        UpdatePolicy policy, const BlockVisitor& visit) const;

 protected:
    OccupancyMap(const OccupancyMap&) = default;
    OccupancyMap& operator=(const OccupancyMap&) = default;

    /// What apply() of every storage begins with: all that may fail.
    /// \return threads to write with  \throws as apply()
    unsigned beginUpdate(const UpdateBatch<Dim>& batch, const SensorModel& model,
                         UpdatePolicy policy, unsigned threads);

    // Take memory from the system, so that writing blocks, each once, cannot fail for want
    // of it: any so many, or these, by one thread. \throws std::bad_alloc, std::length_error
    // \pre the blocks are addressable
    virtual void keepRoomFor(std::size_t blocks, unsigned threads) = 0;
    virtual void keepRoomFor(const WrittenBlocks& written) = 0;

    // Every storage calls these before it changes values.

    /// What setLogOdds() and setBlock() store. Others than finite values are refused.
    void noteValue(float value) {
        if (std::isfinite(value)) range_.include({value, value});
    }
    void noteValues(const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) noteValue(block.values[i]);
    }
    /// What apply() may come to: old values, or between the clamps.
    void noteUpdate(const SensorModel& model) { range_.include({model.min(), model.max()}); }
    void noteCleared() { range_ = {}; }
    void swapValueRange(OccupancyMap& other) { std::swap(range_, other.range_); }

 private:
    CellGeometry<Dim> geometry_;
    LogOddsRange range_;
};

/// Counts and bounds of the known cells.
template <int Dim>
struct MapSummary {
    std::uint64_t known = 0, occupied = 0, free = 0;
    Cell<Dim> lowest{}, highest{};  ///< inclusive cell bounds; valid if known > 0
};
template <int Dim>
MapSummary<Dim> summarize(const OccupancyMap<Dim>& map, const SensorModel& model);

/// 32 hex digits that depend on resolution, dimension, the set of known cells
/// and the bits of their values, and on nothing else (not on storage type or
/// insertion order).
template <int Dim>
std::string contentDigest(const OccupancyMap<Dim>& map);

extern template class OccupancyMap<2>;
extern template class OccupancyMap<3>;

}  // namespace superray
