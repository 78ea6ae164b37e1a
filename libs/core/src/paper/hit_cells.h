// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The cells in which rays of a scan end in a return.

#include <superray/core/ray_bundle.h>

#include "counting/block_directory.h"

#include <vector>

namespace superray {

/// Cells that a scan hits, block by block.
template <int Dim>
class HitCells {
 public:
    /// \param box blocks of all rays
    HitCells(const RayBundle<Dim>& rays, const BlockBox<Dim>& box) {
        directory_.reset(box);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (rays.kind(i) != RayEnd::hit) continue;
            const Cell<Dim> cell = rays.geometry().cellOf(rays.end(i));
            const BlockKey<Dim> key = blockOf<Dim>(cell);
            std::uint32_t id = directory_.id(key);
            if (id == 0) {
                masks_.emplace_back();
                id = static_cast<std::uint32_t>(masks_.size());
                directory_.setId(key, id);
            }
            masks_[id - 1].set(indexInBlock<Dim>(cell));
        }
    }

    /// Those of a block of the box; nullptr: none.
    const BlockMask<Dim>* in(const BlockKey<Dim>& key) const {
        const std::uint32_t id = directory_.id(key);
        return id == 0 ? nullptr : &masks_[id - 1];
    }

 private:
    BlockDirectory<Dim> directory_;  // block -> 1 + index
    std::vector<BlockMask<Dim>> masks_;
};

}  // namespace superray
