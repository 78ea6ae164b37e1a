#pragma once
// The rays of a scan as a tree of beams: beams of a kind are quarters (in 2D,
// halves) of wider ones, down to runs of neighbouring rays.

#include "beam.h"

#include <vector>

namespace superray {

/// A few consecutive rays of a scan, of one kind.
template <int Dim>
struct RayRun : DirectionBounds<Dim> {
    std::uint32_t first;  ///< ray number
    std::uint16_t count;
    std::uint16_t kind;
};

template <int Dim>
class BeamTree {
 public:
    /// A beam: runs [first, last) in the order of the tree.
    struct Node {
        std::uint32_t kind;
        int level;             ///< 0: all directions of the kind
        std::uint32_t number;  ///< among the nodes of this kind and level
        std::uint32_t first, last;
    };

    /// \pre the rays have the common origin
    /// \param shares threads
    void find(const RayBundle<Dim>& rays, std::size_t shares);

    /// Nodes without children have this level.
    int levels() const { return levels_; }
    /// The node of level 0 of a kind (RayDirections; kLone: rays to be walked alone).
    Node root(std::uint32_t kind) const { return node(kind, 0, 0); }
    static constexpr std::uint32_t kKinds = RayDirections<Dim>::kLone + 1;
    static constexpr std::uint32_t kChildren = 1u << (Dim - 1);
    /// \pre n.level < levels()
    Node child(const Node& n, std::uint32_t i) const {
        return node(n.kind, n.level + 1, n.number * kChildren + i);
    }
    const std::vector<RayRun<Dim>>& runs() const { return runs_; }
    DirectionBounds<Dim> bounds(const Node& n) const;

    /// Length of a ray along its dominant axis [cells], roughly.
    float length(std::uint32_t ray) const { return directions_.length[ray]; }

 private:
    using Runs = std::vector<RayRun<Dim>>;

    Node node(std::uint32_t kind, int level, std::uint32_t number) const {
        const int below = (Dim - 1) * (levels_ - level);
        const std::uint32_t* const starts =
            starts_.data() + (kind << ((Dim - 1) * levels_)) + (std::size_t{number} << below);
        return {kind, level, number, starts[0], starts[std::size_t{1} << below]};
    }
    void gather(std::size_t begin, std::size_t end, Runs& runs) const;
    void gatherOneByOne(std::size_t begin, std::size_t end, Runs& runs) const;
    void sort(std::size_t shares);
    std::uint32_t binOf(const RayRun<Dim>& run) const;

    RayDirections<Dim> directions_;
    float widest_ = 0;
    int levels_ = 0;
    std::vector<Runs> runsOfShare_;
    std::vector<std::vector<std::uint32_t>> startsOfShare_;  // per bin
    std::vector<std::uint32_t> starts_;                      // per bin, and the end
    Runs runs_;
};

}  // namespace superray
