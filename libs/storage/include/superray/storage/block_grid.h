// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file block_grid.h
/// Hashed grid of 8^Dim blocks: the fastest storage.

#include <superray/storage/occupancy_map.h>

namespace superray {

template <int Dim>
class BlockGrid final : public OccupancyMap<Dim> {
 public:
    explicit BlockGrid(const CellGeometry<Dim>& geometry);
    BlockGrid(const BlockGrid&);
    ~BlockGrid() override;

    std::unique_ptr<OccupancyMap<Dim>> clone() const override;
    std::unique_ptr<OccupancyMap<Dim>> emptyLike(
        const CellGeometry<Dim>& geometry) const override;
    void swapContents(OccupancyMap<Dim>& other) override;
    using OccupancyMap<Dim>::apply;
    void apply(const UpdateBatch<Dim>& batch, const SensorModel& model, UpdatePolicy policy,
               unsigned threads) override;
    std::optional<float> logOdds(const Cell<Dim>& cell) const override;
    void setLogOdds(const Cell<Dim>& cell, float value) override;
    void setBlock(const BlockView<Dim>& block) override;
    void forEachBlock(const typename OccupancyMap<Dim>::BlockVisitor& visit) const override;
    bool visitBlock(const BlockKey<Dim>& key,
                    const typename OccupancyMap<Dim>::BlockVisitor& visit) const override;
    void clear() override;
    bool empty() const override;
    void reserve(std::size_t bytes) override;
    std::size_t memoryBytes() const override;
    void forgetOutside(const BlockWindow<Dim>& window,
                       const typename OccupancyMap<Dim>::KeyVisitor& forgotten) override;
    std::size_t heldBytes() const override;
    std::size_t heldBytesAtMost(std::size_t blocks, unsigned threads) const override;
    std::size_t heldBytesWith(
        const typename OccupancyMap<Dim>::WrittenBlocks& written) const override;
    BlockSaturation<Dim> saturation(const BlockKey<Dim>& key, float lowerClamp) const override;

 private:
    void keepRoomFor(std::size_t blocks, unsigned threads) override;
    void keepRoomFor(const typename OccupancyMap<Dim>::WrittenBlocks& written) override;

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

extern template class BlockGrid<2>;
extern template class BlockGrid<3>;

}  // namespace superray
