#include <superray/storage/octree.h>

#include "object_pool.h"
#include "tree_storage.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

namespace superray {
namespace {

/// A node whose memory is its tree's.
class PooledNode final : public octomap::OcTreeNode {
 public:
    octomap::AbstractOcTreeNode** children() const { return OcTreeNode::children; }
    void setChildren(octomap::AbstractOcTreeNode** c) { OcTreeNode::children = c; }
};

/// OctoMap's tree, with what TreeWriter needs and OctoMap keeps to itself, and
/// with all nodes in two pools: a node is 16 bytes instead of malloc's 32, and
/// nodes that are made together lie together. OctoMap's code must never free
/// one, so all functions that do are replaced here or not called.
class OcTreeNodes final : public octomap::OcTree {
 public:
    static constexpr int kDim = 3;
    using Node = octomap::OcTreeNode*;
    static constexpr Node kNull = nullptr;

    explicit OcTreeNodes(double cellEdge) : octomap::OcTree(cellEdge) {}
    OcTreeNodes(const OcTreeNodes& o) : octomap::OcTree(o.resolution) {
        setProbHit(o.getProbHit());
        setProbMiss(o.getProbMiss());
        setClampingThresMin(o.getClampingThresMin());
        setClampingThresMax(o.getClampingThresMax());
        setOccupancyThres(o.getOccupancyThres());
        if (o.root() == kNull) return;
        createRoot();
        copyBelow(o.root(), root());
        tree_size = o.tree_size;
    }
    OcTreeNodes& operator=(const OcTreeNodes&) = delete;
    ~OcTreeNodes() override { clearNodes(); }

    // Handles are to non-const nodes; only TreeWriter changes them.
    Node root() const { return octomap::OcTree::root; }
    Node createRoot() {
        octomap::OcTree::root = newNode();
        tree_size = 1;
        size_changed = true;
        return octomap::OcTree::root;
    }
    static Node child(Node n, int i) {
        octomap::AbstractOcTreeNode** const c = pooled(n)->children();
        return c == nullptr ? kNull : static_cast<Node>(c[i]);
    }
    Node createChild(Node n, int i) {
        octomap::AbstractOcTreeNode** c = pooled(n)->children();
        if (c == nullptr) {
            c = families_.allocate()->children;
            std::fill_n(c, 8, nullptr);
            pooled(n)->setChildren(c);
        }
        const Node fresh = newNode();
        c[i] = fresh;
        ++tree_size;
        size_changed = true;
        return fresh;
    }
    /// Inner nodes have a child: families without one are never left behind.
    static bool hasChildren(Node n) { return pooled(n)->children() != nullptr; }
    static float value(Node n) { return n->getLogOdds(); }
    static void setValue(Node n, float v) { n->setLogOdds(v); }
    void expand(Node n) {
        for (int i = 0; i < 8; ++i) setValue(createChild(n, i), value(n));
    }
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
        setValue(n, highest);
        if (same) prune(n);
    }

    void swapWith(OcTreeNodes& o) {
        std::swap(octomap::OcTree::root, o.octomap::OcTree::root);
        std::swap(tree_size, o.tree_size);
        nodes_.swap(o.nodes_);
        families_.swap(o.families_);
        size_changed = o.size_changed = true;  // OctoMap's cached bounds
    }

    void clearNodes() {
        octomap::OcTree::root = nullptr;
        tree_size = 0;
        size_changed = true;
        nodes_.clear();
        families_.clear();
    }

    void use(const SensorProbabilities& p) {
        setProbHit(p.probHit);
        setProbMiss(p.probMiss);
        setClampingThresMin(p.clampMin);
        setClampingThresMax(p.clampMax);
        setOccupancyThres(p.occupancyThreshold);
    }

 private:
    struct Family {
        octomap::AbstractOcTreeNode* children[8];
    };

    static PooledNode* pooled(Node n) { return static_cast<PooledNode*>(n); }
    PooledNode* newNode() { return new (nodes_.allocate()) PooledNode; }

    void prune(Node n) {
        octomap::AbstractOcTreeNode** const c = pooled(n)->children();
        for (int i = 0; i < 8; ++i) nodes_.release(pooled(static_cast<Node>(c[i])));
        families_.release(reinterpret_cast<Family*>(c));
        pooled(n)->setChildren(nullptr);
        tree_size -= 8;
        size_changed = true;
    }

    void copyBelow(Node from, Node to) {
        setValue(to, value(from));
        for (int i = 0; i < 8; ++i)
            if (const Node c = child(from, i); c != kNull) copyBelow(c, createChild(to, i));
    }

    ObjectPool<PooledNode> nodes_;
    ObjectPool<Family> families_;
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
    std::swap(impl_->cache, o.impl_->cache);
}

void Octree::apply(const UpdateBatch<3>& batch, const SensorModel& model, UpdatePolicy policy,
                   unsigned /*threads*/) {
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
    impl_->nodes.clearNodes();
    impl_->cache.clear();
}

bool Octree::empty() const {
    return impl_->nodes.root() == nullptr;
}

std::size_t Octree::memoryBytes() const {
    return impl_->nodes.memoryUsage();
}

BlockSaturation<3> Octree::saturation(const BlockKey<3>& key, float lowerClamp) const {
    return impl_->saturation(key, lowerClamp);
}

}  // namespace superray
