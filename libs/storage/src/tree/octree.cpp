// SPDX-License-Identifier: BSD-3-Clause
#include <superray/storage/octree.h>

#include "tree/octree_nodes.h"
#include "tree/tree_storage.h"

#include <utility>

namespace superray {

struct Octree::Impl : TreeStorage<OcTreeNodes> {
    using TreeStorage::TreeStorage;
};

Octree::Octree(const CellGeometry<3>& geometry)
    : OccupancyMap<3>(geometry), impl_(std::make_unique<Impl>(geometry.resolution())) {}
Octree::Octree(const Octree& o) : OccupancyMap<3>(o), impl_(std::make_unique<Impl>(*o.impl_)) {}
Octree::~Octree() = default;

const octomap::OcTree& Octree::tree() const {
    return impl_->nodes;
}

std::unique_ptr<OccupancyMap<3>> Octree::clone() const {
    return std::make_unique<Octree>(*this);
}

std::unique_ptr<OccupancyMap<3>> Octree::emptyLike(const CellGeometry<3>& geometry) const {
    return std::make_unique<Octree>(geometry);
}

void Octree::swapContents(OccupancyMap<3>& other) {
    auto& o = dynamic_cast<Octree&>(other);
    requireSameResolution(*this, o);
    // Only the nodes move: references to tree() stay valid.
    impl_->nodes.swapWith(o.impl_->nodes);
    std::swap(impl_->cache, o.impl_->cache);
    swapValueRange(o);
}

void Octree::apply(const UpdateBatch<3>& batch, const SensorModel& model, UpdatePolicy policy,
                   unsigned threads) {
    threads = beginUpdate(batch, model, policy, threads);
    impl_->nodes.use(model.probabilities());
    impl_->apply(batch, model, policy, threads);
}

std::optional<float> Octree::logOdds(const Cell<3>& cell) const {
    return impl_->logOdds(cell);
}
void Octree::setLogOdds(const Cell<3>& cell, float value) {
    noteValue(value);
    impl_->setLogOdds(cell, value);
}
void Octree::setBlock(const BlockView<3>& block) {
    noteValues(block);
    impl_->setBlock(block);
}
void Octree::forEachBlock(const BlockVisitor& visit) const {
    impl_->forEachBlock(visit);
}
bool Octree::visitBlock(const BlockKey<3>& key, const BlockVisitor& visit) const {
    return impl_->visitBlock(key, visit);
}

void Octree::clear() {
    impl_->nodes.clearNodes();
    impl_->cache.clear();
    noteCleared();
}

bool Octree::empty() const {
    return impl_->nodes.root() == nullptr;
}

void Octree::reserve(std::size_t bytes) {
    impl_->nodes.reserve(bytes);
}

std::size_t Octree::memoryBytes() const {
    return impl_->nodes.memoryUsage() + impl_->nodes.reservedBytes();
}

void Octree::forgetOutside(const BlockWindow<3>& window, const KeyVisitor& forgotten) {
    impl_->forgetOutside(window, forgotten);
}
std::size_t Octree::heldBytes() const {
    return impl_->nodes.heldBytes();
}
std::size_t Octree::heldBytesAtMost(std::size_t blocks, unsigned threads) const {
    return impl_->nodes.heldBytesWith(OcTreeNodes::growthAtMost(blocks), threads);
}
std::size_t Octree::heldBytesWith(const WrittenBlocks& written) const {
    return impl_->nodes.heldBytesWith(impl_->growthBy(written), 1);
}
void Octree::keepRoomFor(std::size_t blocks, unsigned threads) {
    impl_->keepRoomFor(blocks, threads);
}
void Octree::keepRoomFor(const WrittenBlocks& written) {
    impl_->keepRoomFor(written);
}

BlockSaturation<3> Octree::saturation(const BlockKey<3>& key, float lowerClamp) const {
    return impl_->saturation(key, lowerClamp);
}

}  // namespace superray
