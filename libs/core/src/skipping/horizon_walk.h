#pragma once
// Method `auto`: each ray is walked from where it has something to tell, as far as
// the map and the rays before it leave something to be told.

#include "skipping/hit_counter.h"
#include "skipping/ray_sample.h"
#include "skipping/settled_region.h"
#include "threads/shared_list.h"
#include "kernels/walk_kernel.h"

#include <array>
#include <memory>
#include <vector>

namespace superray {

/// Whether some rays of a part are walked before the others, to spare them what these
/// saturate.
enum class Sampling { never, whereItMayRepay };

/// A scan, and what a walk must know of the map.
template <int Dim>
struct HorizonScan {
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
class HorizonWalk {
 public:
    /// Others may help from now on, until end(). \pre state.reset() was called
    void begin(const HorizonScan<Dim>& scan, WalkState<Dim>& state);

    /// Counts what the rays [first, last) have to tell. Once between begin() and end().
    void walk(std::size_t first, std::size_t last);

    /// The walk is over (also where an exception ends it).
    void end() noexcept { list_->close(); }

    /// Counts some of what another's rays have to tell, until it is done; nothing if it has
    /// not begun. \pre both are of one scan; this one is done
    void help(HorizonWalk& other);

    /// Rays that were cut short or left out, since begin().
    std::uint64_t culled() const { return culled_; }
    const SampleEffect& sampleEffect() const { return sampleEffect_; }
    /// How much there was to do for the rays of walk(), whoever did it: slices to walk,
    /// or what takes as long.
    double work() const { return work_; }

 private:
    // Numbers of rays are among the part that walk() is at; `count` is its size.
    void chooseTiles(std::size_t first, std::size_t last);
    void findDirections(std::size_t count);
    void lookAround(std::size_t count);
    void settleSensorCell(std::size_t count);
    void sample(std::size_t count);
    double slicesLeft(std::size_t count) const;
    bool worthLooking(double slices) const;
    std::size_t walkSample(const std::vector<std::uint32_t>& rays);
    void noteWork(std::size_t chosen, std::size_t oneOf);
    void walkLast(std::size_t count);
    void walkChosen(const HorizonWalk& owner, ListPiece piece);
    void walkWaiting();
    void walkAlone(std::size_t ray);
    void walkLanes(RayLanes& lanes, WalkRays<Dim> kernel);

    const RayBundle<Dim>* rays_ = nullptr;
    WalkState<Dim>* state_ = nullptr;
    WalkKernels<Dim> kernels_;
    Units<Dim> origin_{};
    std::size_t first_ = 0;  // ray that the part begins with
    DirectionTiles<Dim> tiles_;
    RayDirections<Dim> directions_;
    std::array<std::uint32_t, RayDirections<Dim>::kMost + RayDirections<Dim>::kSlack>
        starts_;  // of runs in there
    HitCounter<Dim> hitCounter_;
    Sampling sampling_{};
    SampleEffect sampleEffect_;
    ScratchArray<std::uint32_t> spot_;       // per ray
    ScratchArray<std::uint16_t> lastSlice_;  // per ray
    ScratchArray<std::uint32_t> chosen_;     // rays to walk, in turns with others
    // A few rays, and more of them, which the first ones spare much of their way.
    static constexpr double kFirstSample = 1.0 / 148, kWholeSample = 4.0 / 37;
    RaySample firstSample_{0, kFirstSample}, sample_{kFirstSample, kWholeSample};
    std::unique_ptr<SharedList> list_ = std::make_unique<SharedList>();
    Horizon<Dim> horizon_;
    SettledRegion<Dim> region_;
    // Rays that wait for others, per kind: those with many, with few slices left.
    std::array<std::array<RayLanes, 2>, DirectionTiles<Dim>::kKinds> waiting_;
    std::uint64_t culled_ = 0;
    double work_ = 0;
};

}  // namespace superray
