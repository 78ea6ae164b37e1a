// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Method `auto`: each ray is walked from where it has something to tell, as far as
// the map and the rays before it leave something to be told.

#include "kernels/walk_kernel.h"
#include "skipping/hit_counter.h"
#include "skipping/ray_sample.h"
#include "skipping/settled_region.h"
#include "threads/work_queue.h"

#include <array>
#include <memory>
#include <vector>

namespace superray {

/// Whether some rays of a part are walked before the others, to spare them what these
/// saturate.
enum class Sampling { never, whereItMayRepay };

/// A scan, and what a walk must know of the map.
template <int Dim>
struct SkippingScan {
    const RayBundle<Dim>& rays;        ///< with the common origin; must outlive the walk
    const SaturationSource<Dim>* map;  ///< nullptr: none; must outlive the walk
    SaturationLimits limits;
    Sampling sampling;
};

/// Slices that were left to walk of all rays where a sample might repay, before and after it.
struct SampleEffect {
    double before = 0, after = 0;
};

/// One thread's part of a scan: begin(), walk(), end(); then it may help others.
template <int Dim>
class SkippingWalk {
 public:
    /// Others may help from now on, until end(). \pre state.reset() was called
    void begin(const SkippingScan<Dim>& scan, ScanCounts<Dim>& counts);

    /// Counts what the rays [first, last) have to tell. Once between begin() and end().
    void walk(std::size_t first, std::size_t last);

    /// The walk is over (also where an exception ends it).
    void end() noexcept { queue_->finish(); }

    /// Counts some of what another's rays have to tell, until it is done; nothing if it has
    /// not begun. \pre both are of one scan; this one is done
    void help(SkippingWalk& other);

    /// Rays that were cut short or left out, since begin().
    std::uint64_t culled() const { return culled_; }
    const SampleEffect& sampleEffect() const { return sampleEffect_; }
    /// How much there was to do for the rays of walk(), whoever did it: slices to walk,
    /// or what takes as long.
    double work() const { return work_; }

 private:
    // Numbers of rays are among the part that walk() is at; `count` is its size.
    void chooseBins(std::size_t first, std::size_t last);
    void classifyRays(std::size_t count);
    void growRegion(std::size_t count);
    void settleSensorCell(std::size_t count);
    void sample(std::size_t count);
    double slicesLeft(std::size_t count) const;
    bool worthGrowing(double slices) const;
    std::size_t walkSample(const std::vector<std::uint32_t>& rays);
    void addWork(std::size_t chosen, std::size_t oneOf);
    void walkLast(std::size_t count);
    void walkChosen(const SkippingWalk& owner, WorkPiece piece);
    void walkWaiting();
    void walkUnclassified(std::size_t ray);
    void walkLanes(RayLanes& lanes, WalkRays<Dim> kernel);

    const RayBundle<Dim>* rays_ = nullptr;
    ScanCounts<Dim>* counts_ = nullptr;
    WalkKernels<Dim> kernels_;
    Units<Dim> origin_{};
    std::size_t first_ = 0;  // ray that the part begins with
    DirectionBins<Dim> bins_;
    ClassifiedBatch<Dim> directions_;
    std::array<std::uint32_t, ClassifiedBatch<Dim>::kMost + ClassifiedBatch<Dim>::kSlack>
        starts_;  // of runs in there
    HitCounter<Dim> hitCounter_;
    Sampling sampling_{};
    SampleEffect sampleEffect_;
    ScratchArray<std::uint32_t> subBin_;     // per ray
    ScratchArray<std::uint16_t> lastSlice_;  // per ray
    ScratchArray<std::uint32_t> chosen_;     // rays to walk, in turns with others
    // A few rays, and more of them, which the first ones spare much of their way.
    static constexpr double kFirstSample = 1.0 / 148, kWholeSample = 4.0 / 37;
    RaySample firstSample_{0, kFirstSample}, sample_{kFirstSample, kWholeSample};
    std::unique_ptr<WorkQueue> queue_ = std::make_unique<WorkQueue>();
    DirectionRanges<Dim> ranges_;
    SettledRegion<Dim> region_;
    // Rays that wait for others, per sector: those with many, with few slices left.
    std::array<std::array<RayLanes, 2>, DirectionBins<Dim>::kSectors> waiting_;
    std::uint64_t culled_ = 0;
    double work_ = 0;
};

}  // namespace superray
