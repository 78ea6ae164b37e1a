#pragma once
// Method `auto`: neighbouring rays are walked as beams, from where the map and
// this scan have not yet saturated every cell that the beam can visit.

#include "beam_tree.h"
#include "end_addresses.h"
#include "walk_kernel.h"

namespace superray {

/// Whether to look ahead before some rays are walked: while looks have saved more
/// than they cost. Asks for a look now and then, to notice when that changes.
class WorthALook {
 public:
    bool now() { return saved_ > kCost || ++refused_ % kProbe == 0; }
    /// \param saved slices of all rays that need not be walked
    void learn(float saved) { saved_ += (saved - saved_) * (1.0f / 16); }

 private:
    /// A look costs about as much as walking so many slices.
    static constexpr float kCost = 25;
    static constexpr std::uint32_t kProbe = 16;
    float saved_ = 2 * kCost;
    std::uint32_t refused_ = 0;
};

/// One thread's part of a scan: begin(), then addHits() and walk() of its beams,
/// then end().
template <int Dim>
class BeamWalk {
 public:
    using Node = typename BeamTree<Dim>::Node;

    /// \pre state.reset() and state.countMapSaturation() were called
    void begin(const RayBundle<Dim>& rays, const BeamTree<Dim>& tree,
               const EndAddresses<Dim>& ends, WalkState<Dim>& state);

    /// Counts the hits of all rays, or of those of a node. Those that make
    /// misses irrelevant spare the walks, so hits had better come first.
    void addHits() { addHits(0, rays_->size()); }
    void addHits(const Node& node);

    /// Walks what the rays of a node have to tell.
    void walk(const Node& node);

    void end() { state_->flush(1); }

    /// Rays that were cut short or left out, since begin().
    std::uint64_t culled() const { return culled_; }

 private:
    struct Leaf;

    void addHits(std::size_t begin, std::size_t end);
    void walkBelow(const Node& node, std::int32_t slice);
    void walkRuns(const Node& node, std::uint64_t rays, std::int32_t slice);
    void lookAhead(const DirectionBounds<Dim>& rays, Look& look);
    void walkLeaf(Leaf& leaf, std::int32_t from);
    void walkLone(const RayRun<Dim>& run);
    std::uint64_t raysOf(std::uint32_t first, std::uint32_t last, std::uint32_t step) const;

    const RayBundle<Dim>* rays_ = nullptr;
    const BeamTree<Dim>* tree_ = nullptr;
    const EndAddresses<Dim>* ends_ = nullptr;
    WalkState<Dim>* state_ = nullptr;
    WalkKernels<Dim> kernels_;
    Units<Dim> origin_{};
    BeamStart<Dim> start_;
    WorthALook worthALook_;
    std::uint64_t culled_ = 0;
};

}  // namespace superray
