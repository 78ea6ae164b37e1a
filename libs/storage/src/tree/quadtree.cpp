// SPDX-License-Identifier: BSD-3-Clause
#include <superray/storage/quadtree.h>

#include "containers/chunked_pool.h"
#include "tree/tree_growth.h"
#include "tree/tree_storage.h"

#include <limits>

namespace superray {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Nodes in families of four siblings: 8 bytes each.
class QuadNodes {
 public:
    static constexpr int kDim = 2;
    using Node = std::uint32_t;  // 4 * family + number in the family
    static constexpr Node kNull = kNone;

    static constexpr bool kParallel = false;  // one pool for all
    /// Those of writing to a block, at most, with the way to it.
    static constexpr std::uint32_t kFamiliesOfWrite = 64;
    static_assert(kFamiliesOfWrite >= kBlockDepth + kFamiliesOfBlock<2>);

    Node root() const { return root_; }
    void setRoot(Node n) { root_ = n; }
    Node child(Node n, int i) const {
        if (!hasChildren(n)) return kNull;
        const Node c = at(n).children * 4 + static_cast<Node>(i);
        return at(c).exists() ? c : kNull;
    }
    bool hasChildren(Node n) const { return at(n).children != kNone; }
    float value(Node n) const { return at(n).value; }
    std::uint8_t readChildren(Node n, unsigned which, float* values) const {
        const Family& family = families_[at(n).children];
        unsigned had = 0;
        for (unsigned i = 0; i < 4; ++i) {
            const Record& c = family.nodes[i];
            values[i] = c.exists() ? c.value : which >> i & 1 ? 0 : kAbsent;
            had |= static_cast<unsigned>(c.exists()) << i;
        }
        return static_cast<std::uint8_t>(had);
    }
    void prefetchFamily(Node n) const {
        if (hasChildren(n)) __builtin_prefetch(&at(at(n).children * 4));
    }
    static void prefetchChildren(Node) {}  // they are the family

    class Editor {
     public:
        explicit Editor(QuadNodes& nodes) : nodes_(nodes) {}

        /// Makes sure that nothing fails until a block and the way to it are made.
        void reserve() { nodes_.families_.keepRoom(kFamiliesOfWrite); }
        void setValue(Node n, float v) { nodes_.at(n).value = v; }
        Node create() {
            const Node n = 4 * nodes_.newFamily();  // its siblings are never used
            setValue(n, 0);
            return n;
        }
        void setChildren(Node n, const float* values) {
            Family& family = nodes_.families_[nodes_.at(n).children];
            for (unsigned i = 0; i < 4; ++i)
                if (family.nodes[i].exists()) family.nodes[i].value = values[i];
        }
        void createChildren(Node n, unsigned which, const float* values) {
            const std::uint32_t family = familyOf(n);
            for (unsigned i = 0; i < 4; ++i)
                if (which >> i & 1) setValue(4 * family + i, values[i]);
        }
        void createChildren(Node n, unsigned which, float value) {
            const float values[4] = {value, value, value, value};
            createChildren(n, which, values);
        }
        void removeChildren(Node n) {
            nodes_.families_.release(nodes_.at(n).children);
            nodes_.at(n).children = kNone;
        }
        /// What TreeForget asks for.
        void reserveSplit() { nodes_.families_.keepRoom(1); }
        /// Removes one child, a leaf. \return whether that was the last: then n is a leaf
        bool removeChild(Node n, int i) {
            Family& family = nodes_.families_[nodes_.at(n).children];
            family.nodes[i].value = std::numeric_limits<float>::quiet_NaN();
            for (const Record& child : family.nodes)
                if (child.exists()) return false;
            removeChildren(n);
            return true;
        }
        /// Takes a node without children and parent back.
        void release(Node n) { nodes_.families_.release(n / 4); }
        void settle(Node n) {
            const Family& family = nodes_.families_[nodes_.at(n).children];
            bool same = true;
            float highest = std::numeric_limits<float>::lowest();
            for (const Record& child : family.nodes) {
                same = same && child.value == family.nodes[0].value && child.children == kNone;
                if (child.exists()) highest = std::max(highest, child.value);
            }
            if (same) removeChildren(n);
            setValue(n, highest);
        }

     private:
        std::uint32_t familyOf(Node n) {
            if (!nodes_.hasChildren(n)) {
                const std::uint32_t family = nodes_.newFamily();
                nodes_.at(n).children = family;
            }
            return nodes_.at(n).children;
        }
        QuadNodes& nodes_;
    };

    std::size_t memoryBytes() const { return families_.memoryBytes(); }
    std::size_t memoryBytesWith(const TreeGrowth& growth) const {
        return families_.memoryBytesAtMost(roomFor(growth));
    }
    /// The most that writing to so many blocks can make.
    static TreeGrowth growthAtMost(std::size_t blocks) {
        return {0, blocks * kFamiliesOfWrite, blocks};
    }
    /// Makes sure that a growth cannot fail. \throws std::bad_alloc, std::length_error
    void keepRoom(const TreeGrowth& growth, unsigned /*threads*/) {
        families_.keepRoom(roomFor(growth));
    }
    void reserve(std::size_t bytes) { families_.reserve(bytes); }
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

    /// Editor::reserve() keeps room for one more block.
    static std::size_t roomFor(const TreeGrowth& g) {
        return g.blocks == 0 ? 0 : g.families + kFamiliesOfWrite + 1;
    }
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
    swapValueRange(o);
}

void Quadtree::apply(const UpdateBatch<2>& batch, const SensorModel& model, UpdatePolicy policy,
                     unsigned threads) {
    threads = beginUpdate(batch, model, policy, threads);
    impl_->apply(batch, model, policy, threads);
}

std::optional<float> Quadtree::logOdds(const Cell<2>& cell) const {
    return impl_->logOdds(cell);
}
void Quadtree::setLogOdds(const Cell<2>& cell, float value) {
    noteValue(value);
    impl_->setLogOdds(cell, value);
}
void Quadtree::setBlock(const BlockView<2>& block) {
    noteValues(block);
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
    noteCleared();
}
bool Quadtree::empty() const {
    return impl_->nodes.root() == kNone;
}

void Quadtree::reserve(std::size_t bytes) {
    impl_->nodes.reserve(bytes);
}

std::size_t Quadtree::memoryBytes() const {
    return sizeof(Impl) + impl_->nodes.memoryBytes();
}

void Quadtree::forgetOutside(const BlockWindow<2>& window, const KeyVisitor& forgotten) {
    impl_->forgetOutside(window, forgotten);
}
std::size_t Quadtree::heldBytes() const {
    return memoryBytes();
}
std::size_t Quadtree::heldBytesAtMost(std::size_t blocks, unsigned) const {
    return sizeof(Impl) + impl_->nodes.memoryBytesWith(QuadNodes::growthAtMost(blocks));
}
std::size_t Quadtree::heldBytesWith(const WrittenBlocks& written) const {
    return sizeof(Impl) + impl_->nodes.memoryBytesWith(impl_->growthBy(written));
}
void Quadtree::keepRoomFor(std::size_t blocks, unsigned threads) {
    impl_->keepRoomFor(blocks, threads);
}
void Quadtree::keepRoomFor(const WrittenBlocks& written) {
    impl_->keepRoomFor(written);
}

BlockSaturation<2> Quadtree::saturation(const BlockKey<2>& key, float lowerClamp) const {
    return impl_->saturation(key, lowerClamp);
}

}  // namespace superray
