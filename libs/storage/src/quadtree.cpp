#include <superray/storage/quadtree.h>

#include "chunked_pool.h"
#include "tree_storage.h"

namespace superray {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Nodes in families of four siblings: 8 bytes each.
class QuadNodes {
 public:
    static constexpr int kDim = 2;
    using Node = std::uint32_t;  // 4 * family + number in the family
    static constexpr Node kNull = kNone;

    Node root() const { return root_; }
    Node createRoot() {
        root_ = 4 * newFamily();  // its siblings are never used
        setValue(root_, 0);
        return root_;
    }

    Node child(Node n, int i) const {
        if (!hasChildren(n)) return kNull;
        const Node c = at(n).children * 4 + static_cast<Node>(i);
        return at(c).exists() ? c : kNull;
    }
    Node createChild(Node n, int i) {
        if (!hasChildren(n)) {
            const std::uint32_t family = newFamily();
            at(n).children = family;
        }
        const Node c = at(n).children * 4 + static_cast<Node>(i);
        at(c).value = 0;
        return c;
    }
    bool hasChildren(Node n) const { return at(n).children != kNone; }
    float value(Node n) const { return at(n).value; }
    void setValue(Node n, float v) { at(n).value = v; }

    void expand(Node n) {
        const float v = value(n);
        for (int i = 0; i < 4; ++i) setValue(createChild(n, i), v);
    }

    void settle(Node n) {
        const Family& family = families_[at(n).children];
        bool same = true;
        float highest = std::numeric_limits<float>::lowest();
        for (const Record& child : family.nodes) {
            same = same && child.value == family.nodes[0].value && child.children == kNone;
            if (child.exists()) highest = std::max(highest, child.value);
        }
        if (same) {
            families_.release(at(n).children);
            at(n).children = kNone;
        }
        at(n).value = highest;
    }

    std::size_t memoryBytes() const { return families_.memoryBytes(); }
    void clear() {
        families_.clear();
        root_ = kNull;
    }

 private:
    struct Record {
        float value;             // NaN: no such node
        std::uint32_t children;  // their family; kNone for a leaf
        bool exists() const { return value == value; }
    };
    struct Family {
        Record nodes[4];
    };

    std::uint32_t newFamily() {
        const std::uint32_t f = families_.allocate();
        for (Record& r : families_[f].nodes)
            r = {std::numeric_limits<float>::quiet_NaN(), kNone};
        return f;
    }
    Record& at(Node n) { return families_[n / 4].nodes[n % 4]; }
    const Record& at(Node n) const { return families_[n / 4].nodes[n % 4]; }

    ChunkedPool<Family, 256> families_;
    Node root_ = kNull;
};

}  // namespace

struct Quadtree::Impl : TreeStorage<QuadNodes> {
    using TreeStorage::TreeStorage;
};

Quadtree::Quadtree(const CellGeometry<2>& geometry)
    : OccupancyMap<2>(geometry), impl_(std::make_unique<Impl>()) {}
Quadtree::Quadtree(const Quadtree& o)
    : OccupancyMap<2>(o), impl_(std::make_unique<Impl>(*o.impl_)) {}
Quadtree::~Quadtree() = default;

std::unique_ptr<OccupancyMap<2>> Quadtree::clone() const {
    return std::make_unique<Quadtree>(*this);
}

std::unique_ptr<OccupancyMap<2>> Quadtree::emptyLike(const CellGeometry<2>& geometry) const {
    return std::make_unique<Quadtree>(geometry);
}

void Quadtree::swapContents(OccupancyMap<2>& other) {
    auto& o = dynamic_cast<Quadtree&>(other);
    requireSameResolution(*this, o);
    impl_.swap(o.impl_);
}

void Quadtree::apply(const UpdateBatch<2>& batch, const SensorModel& model, UpdatePolicy policy,
                     unsigned /*threads*/) {
    impl_->apply(batch, model, policy);
}

std::optional<float> Quadtree::logOdds(const Cell<2>& cell) const {
    return impl_->logOdds(cell);
}
void Quadtree::setLogOdds(const Cell<2>& cell, float value) {
    impl_->setLogOdds(cell, value);
}
void Quadtree::setBlock(const BlockView<2>& block) {
    impl_->setBlock(block);
}
void Quadtree::forEachBlock(const BlockVisitor& visit) const {
    impl_->forEachBlock(visit);
}
bool Quadtree::visitBlock(const BlockKey<2>& key, const BlockVisitor& visit) const {
    return impl_->visitBlock(key, visit);
}
void Quadtree::clear() {
    impl_ = std::make_unique<Impl>();
}
bool Quadtree::empty() const {
    return impl_->nodes.root() == kNone;
}

std::size_t Quadtree::memoryBytes() const {
    return sizeof(Impl) + impl_->nodes.memoryBytes();
}

BlockSaturation<2> Quadtree::saturation(const BlockKey<2>& key, float lowerClamp) const {
    return impl_->saturation(key, lowerClamp);
}

}  // namespace superray
