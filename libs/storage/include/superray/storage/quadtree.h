// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file quadtree.h
/// 2D storage in a pruned quadtree: the octree's algorithms, four children.

#include <superray/storage/occupancy_map.h>

namespace superray {

class Quadtree final : public OccupancyMap<2> {
 public:
    explicit Quadtree(const CellGeometry<2>& geometry);
    Quadtree(const Quadtree&);
    ~Quadtree() override;

    std::unique_ptr<OccupancyMap<2>> clone() const override;
    std::unique_ptr<OccupancyMap<2>> emptyLike(const CellGeometry<2>& geometry) const override;
    void swapContents(OccupancyMap<2>& other) override;
    using OccupancyMap<2>::apply;
    void apply(const UpdateBatch<2>& batch, const SensorModel& model, UpdatePolicy policy,
               unsigned threads) override;
    std::optional<float> logOdds(const Cell<2>& cell) const override;
    void setLogOdds(const Cell<2>& cell, float value) override;
    void setBlock(const BlockView<2>& block) override;
    void forEachBlock(const BlockVisitor& visit) const override;
    bool visitBlock(const BlockKey<2>& key, const BlockVisitor& visit) const override;
    void clear() override;
    bool empty() const override;
    void reserve(std::size_t bytes) override;
    std::size_t memoryBytes() const override;
    void forgetOutside(const BlockWindow<2>& window, const KeyVisitor& forgotten) override;
    std::size_t heldBytes() const override;
    std::size_t heldBytesAtMost(std::size_t blocks, unsigned threads) const override;
    std::size_t heldBytesWith(const WrittenBlocks& written) const override;
    BlockSaturation<2> saturation(const BlockKey<2>& key, float lowerClamp) const override;

 private:
    void keepRoomFor(std::size_t blocks, unsigned threads) override;
    void keepRoomFor(const WrittenBlocks& written) override;

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace superray
