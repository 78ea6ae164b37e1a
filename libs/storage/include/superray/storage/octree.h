// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octree.h
/// Storage in an octomap::OcTree, updated a block at a time.

#include <superray/storage/occupancy_map.h>

namespace octomap {
class OcTree;
}

namespace superray {

class Octree final : public OccupancyMap<3> {
 public:
    explicit Octree(const CellGeometry<3>& geometry);
    Octree(const Octree&);
    ~Octree() override;

    /// The tree itself: inner nodes up to date (maximum of the children) and
    /// pruned, as OctoMap keeps them. Its sensor-model members follow the last
    /// apply(), so isNodeOccupied() agrees with the map.
    const octomap::OcTree& tree() const;

    std::unique_ptr<OccupancyMap<3>> clone() const override;
    std::unique_ptr<OccupancyMap<3>> emptyLike(const CellGeometry<3>& geometry) const override;
    void swapContents(OccupancyMap<3>& other) override;
    using OccupancyMap<3>::apply;
    void apply(const UpdateBatch<3>& batch, const SensorModel& model, UpdatePolicy policy,
               unsigned threads) override;
    std::optional<float> logOdds(const Cell<3>& cell) const override;
    void setLogOdds(const Cell<3>& cell, float value) override;
    void setBlock(const BlockView<3>& block) override;
    void forEachBlock(const BlockVisitor& visit) const override;
    bool visitBlock(const BlockKey<3>& key, const BlockVisitor& visit) const override;
    void clear() override;
    bool empty() const override;
    void reserve(std::size_t bytes) override;
    std::size_t memoryBytes() const override;
    void forgetOutside(const BlockWindow<3>& window, const KeyVisitor& forgotten) override;
    std::size_t heldBytes() const override;
    std::size_t heldBytesAtMost(std::size_t blocks, unsigned threads) const override;
    std::size_t heldBytesWith(const WrittenBlocks& written) const override;
    BlockSaturation<3> saturation(const BlockKey<3>& key, float lowerClamp) const override;

 private:
    void keepRoomFor(std::size_t blocks, unsigned threads) override;
    void keepRoomFor(const WrittenBlocks& written) override;

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace superray
