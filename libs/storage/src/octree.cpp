#include <superray/storage/octree.h>

#include "tree_storage.h"

#include <octomap/OcTree.h>

namespace superray {
namespace {

/// OctoMap's tree, with what TreeWriter needs and OctoMap keeps to itself.
class OcTreeNodes final : public octomap::OcTree {
 public:
    static constexpr int kDim = 3;
    using Node = octomap::OcTreeNode*;
    static constexpr Node kNull = nullptr;

    explicit OcTreeNodes(double cellEdge) : octomap::OcTree(cellEdge) {}

    // Handles are to non-const nodes; only TreeWriter changes them.
    Node root() const { return octomap::OcTree::root; }
    Node createRoot() {
        octomap::OcTree::root = new octomap::OcTreeNode();
        tree_size = 1;
        size_changed = true;
        return octomap::OcTree::root;
    }
    Node child(Node n, int i) const {
        const auto u = static_cast<unsigned>(i);
        return nodeChildExists(n, u) ? getNodeChild(n, u) : kNull;
    }
    Node createChild(Node n, int i) { return createNodeChild(n, static_cast<unsigned>(i)); }
    bool hasChildren(Node n) const { return nodeHasChildren(n); }
    static float value(Node n) { return n->getLogOdds(); }
    static void setValue(Node n, float v) { n->setLogOdds(v); }
    void expand(Node n) { expandNode(n); }
    void settle(Node n) {
        // As pruneNode() and updateOccupancyChildren(), in one visit.
        bool same = true;
        float highest = std::numeric_limits<float>::lowest();
        for (int i = 0; i < 8; ++i) {
            const Node c = child(n, i);
            if (c == kNull) {
                same = false;
                continue;
            }
            same = same && !hasChildren(c) && (i == 0 || value(c) == highest);
            highest = std::max(highest, value(c));
        }
        if (!same || !pruneNode(n)) setValue(n, highest);
    }

    void swapWith(OcTreeNodes& o) {
        swapContent(o);
        size_changed = o.size_changed = true;  // OctoMap's cached bounds
    }

    void use(const SensorProbabilities& p) {
        setProbHit(p.probHit);
        setProbMiss(p.probMiss);
        setClampingThresMin(p.clampMin);
        setClampingThresMax(p.clampMax);
        setOccupancyThres(p.occupancyThreshold);
    }
};

}  // namespace

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
    impl_->saturated.swap(o.impl_->saturated);
}

void Octree::apply(const UpdateBatch<3>& batch, const SensorModel& model, UpdatePolicy policy) {
    impl_->nodes.use(model.probabilities());
    impl_->apply(batch, model, policy);
}

std::optional<float> Octree::logOdds(const Cell<3>& cell) const {
    return impl_->logOdds(cell);
}
void Octree::setLogOdds(const Cell<3>& cell, float value) {
    impl_->setLogOdds(cell, value);
}
void Octree::setBlock(const BlockView<3>& block) {
    impl_->setBlock(block);
}
void Octree::forEachBlock(const BlockVisitor& visit) const {
    impl_->forEachBlock(visit);
}
bool Octree::visitBlock(const BlockKey<3>& key, const BlockVisitor& visit) const {
    return impl_->visitBlock(key, visit);
}

void Octree::clear() {
    impl_->nodes.clear();
    impl_->saturated.clear();
}

bool Octree::empty() const {
    return impl_->nodes.root() == nullptr;
}

std::size_t Octree::memoryBytes() const {
    return impl_->nodes.memoryUsage() + impl_->saturated.memoryBytes();
}

const BlockMask<3>* Octree::saturatedFree(const BlockKey<3>& key, float lowerClamp) const {
    return impl_->saturatedFree(key, lowerClamp);
}

}  // namespace superray
