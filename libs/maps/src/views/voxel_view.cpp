// SPDX-License-Identifier: BSD-3-Clause
#include "views/voxel_view.h"

#include <mrpt/img/color_maps.h>

#include <algorithm>

namespace superray {
namespace {

using mrpt_viz::COctoMapVoxels;

constexpr std::array<std::size_t, 2> kSets{mrpt_viz::VOXEL_SET_OCCUPIED,
                                           mrpt_viz::VOXEL_SET_FREESPACE};

template <int Dim>
mrpt::math::TPoint3Df centerOf(const Cell<Dim>& cell, const CellGeometry<Dim>& geometry) {
    const Point<Dim> p = geometry.center(cell);
    return {static_cast<float>(p[0]), static_cast<float>(p[1]),
            Dim == 3 ? static_cast<float>(p[Dim - 1]) : 0.0f};
}

/// Colour of a value on the scale [low, high].
mrpt::img::TColor onScale(double value, double low, double high) {
    const double t = high > low ? (value - low) / (high - low) : 1.0;
    return toColor(
        mrpt::img::colormap(mrpt::img::cmJET, static_cast<float>(std::clamp(t, 0.0, 1.0))));
}

/// Blocks that changed since the last view: with more, reading the whole map costs no more.
constexpr std::size_t kMostNotes = std::size_t{1} << 18;

template <class Key>
void sortUnique(std::vector<Key>& keys) {
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

/// Appends to a list that nobody may read for long: repeated keys are dropped
/// whenever it has doubled.
template <class Key>
void note(std::vector<Key>& keys, const Key& key) {
    if (keys.size() == keys.capacity() && keys.size() >= 4096) sortUnique(keys);
    keys.push_back(key);
}

}  // namespace

template <int Dim>
void VoxelView<Dim>::applied(const UpdateBatch<Dim>& batch) {
    if (!built_) return;
    for (std::size_t b = 0; b < batch.blockCount(); ++b)
        note(batch.hits(b) ? hit_ : missed_, batch.key(b));
    limitNotes();
}

template <int Dim>
void VoxelView<Dim>::applied(const CellCountMap<Dim>& counts) {
    if (!built_) return;
    for (const auto& [cell, count] : counts) note(hit_, blockOf<Dim>(cell));
    limitNotes();
}

template <int Dim>
void VoxelView<Dim>::forgotten(const std::vector<BlockKey<Dim>>& keys) {
    if (!built_) return;
    for (const Key& key : keys) note(hit_, key);
    limitNotes();
}

template <int Dim>
void VoxelView<Dim>::limitNotes() {
    if (hit_.size() + missed_.size() <= kMostNotes) return;
    forget();
    hit_ = {};
    missed_ = {};
}

template <int Dim>
bool VoxelView<Dim>::Style::sameAs(const Style& o) const {
    return resolution == o.resolution && model.occupied() == o.model.occupied() &&
           model.min() == o.model.min() && model.max() == o.model.max() &&
           options.generateOccupiedVoxels == o.options.generateOccupiedVoxels &&
           options.generateFreeVoxels == o.options.generateFreeVoxels &&
           options.colour == o.options.colour;
}

template <int Dim>
mrpt::img::TColor VoxelView<Dim>::colourOf(float value, float z) const {
    if (style_->options.colour == VoxelColour::height) return onScale(z, low_, high_);
    return onScale(probabilityOf(value), probabilityOf(style_->model.min()),
                   probabilityOf(style_->model.max()));
}

template <int Dim>
void VoxelView<Dim>::readBlock(const BlockView<Dim>& view, const CellGeometry<Dim>& geometry) {
    ++blocksRead_;
    Block block;
    block.lowest.fill(kCellLimit);
    block.highest.fill(-kCellLimit);
    for (int i = 0; i < kBlockCells<Dim>; ++i) {
        const float value = view.known.test(i) ? view.values[i] : 0.0f;
        if (!view.known.test(i) || !style_->draws(value)) continue;
        const Cell<Dim> cell = cellInBlock<Dim>(view.key, i);
        for (std::size_t a = 0; a < Dim; ++a) {
            block.lowest[a] = std::min(block.lowest[a], cell[a]);
            block.highest[a] = std::max(block.highest[a], cell[a]);
        }
        const auto center = centerOf<Dim>(cell, geometry);
        block.sets[value >= style_->model.occupied() ? 0 : 1].push_back(
            {center, geometry.resolution(), colourOf(value, center.z)});
    }
    if (block.sets[0].empty() && block.sets[1].empty()) {
        blocks_.erase(view.key);
    } else {
        blocks_[view.key] = std::move(block);
    }
}

template <int Dim>
void VoxelView<Dim>::refresh(const OccupancyMap<Dim>& map, const Style& style) {
    blocksRead_ = 0;
    const auto& geometry = map.geometry();
    const auto read = [&](const BlockView<Dim>& view) { readBlock(view, geometry); };
    const bool changedStyle = !style_ || !style.sameAs(*style_);
    style_ = std::make_unique<Style>(style);
    if (!built_ || changedStyle) {
        blocks_.clear();
        map.forEachBlock(read);
    } else {
        // A miss seldom makes a cell appear: only where free cells are drawn, or
        // where the threshold is so low that a missed cell counts as occupied.
        const bool missesMayShow = style.options.generateFreeVoxels ||
                                   style.model.afterFewestMisses() >= style.model.occupied();
        sortUnique(missed_);
        for (const Key& key : missed_)
            if (missesMayShow || blocks_.count(key) != 0) hit_.push_back(key);
        sortUnique(hit_);
        for (const Key& key : hit_)
            if (!map.visitBlock(key, read)) blocks_.erase(key);
    }
    built_ = true;
    hit_.clear();
    missed_.clear();

    lowest_.fill(kCellLimit);
    highest_.fill(-kCellLimit);
    for (const auto& [key, block] : blocks_) {
        for (std::size_t a = 0; a < Dim; ++a) {
            lowest_[a] = std::min(lowest_[a], block.lowest[a]);
            highest_[a] = std::max(highest_[a], block.highest[a]);
        }
    }
}

template <int Dim>
void VoxelView<Dim>::scaleHeightColours() {
    const CellGeometry<Dim> geometry(style_->resolution);
    // clang-tidy does not see that center() sets all axes.
    // NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Assign)
    const double low = centerOf<Dim>(lowest_, geometry).z;
    const double high = centerOf<Dim>(highest_, geometry).z;
    if (low == low_ && high == high_) return;
    low_ = low;
    high_ = high;
    for (auto& [key, block] : blocks_)
        for (auto& set : block.sets)
            for (Voxel& v : set) v.color = onScale(v.coords.z, low, high);
}

template <int Dim>
std::shared_ptr<COctoMapVoxels> VoxelView<Dim>::draw(const OccupancyMap<Dim>& map,
                                                     const SensorModel& model,
                                                     const TRenderingOptions& options) {
    const std::lock_guard<std::mutex> lock(drawing_);
    refresh(map, {map.geometry().resolution(), model, options});
    const bool byHeight = options.colour == VoxelColour::height;

    // Made and destroyed by MRPT's own code, which UBSan can follow.
    auto voxels = std::dynamic_pointer_cast<COctoMapVoxels>(COctoMapVoxels::CreateObject());
    voxels->setVisualizationMode(byHeight ? COctoMapVoxels::COLOR_FROM_HEIGHT
                                          : COctoMapVoxels::COLOR_FROM_OCCUPANCY);
    voxels->enableCubeTransparency(false);
    voxels->showGridLines(options.generateGridLines);
    voxels->resizeVoxelSets(kSets.size());
    voxels->showVoxels(mrpt_viz::VOXEL_SET_OCCUPIED, options.visibleOccupiedVoxels);
    voxels->showVoxels(mrpt_viz::VOXEL_SET_FREESPACE, options.visibleFreeVoxels);
    if (blocks_.empty()) return voxels;
    if (byHeight) scaleHeightColours();

    const auto half = static_cast<float>(map.geometry().resolution() / 2);
    const mrpt::math::TPoint3Df halfCell(half, half, half);
    std::size_t cubes = 0;
    for (std::size_t s = 0; s < kSets.size(); ++s) {
        std::size_t count = 0;
        for (const auto& [key, block] : blocks_) count += block.sets[s].size();
        if (count == 0) continue;
        voxels->resizeVoxels(kSets[s], count);
        // One reference for all: MRPT takes locks each time that it gives one.
        Voxel* next = &voxels->getVoxelRef(kSets[s], 0);
        for (const auto& [key, block] : blocks_)
            next = std::copy(block.sets[s].begin(), block.sets[s].end(), next);
        if (!options.generateGridLines) continue;
        voxels->resizeGridCubes(cubes + count);
        auto* cube = &voxels->getGridCubeRef(cubes);
        for (const Voxel* v = next - count; v != next; ++v)
            *cube++ = {v->coords - halfCell, v->coords + halfCell};
        cubes += count;
    }
    const auto low = centerOf<Dim>(lowest_, map.geometry()) - halfCell;
    const auto high = centerOf<Dim>(highest_, map.geometry()) + halfCell;
    voxels->setBoundingBox({low.x, low.y, low.z}, {high.x, high.y, high.z});
    return voxels;
}

template class VoxelView<2>;
template class VoxelView<3>;

}  // namespace superray
