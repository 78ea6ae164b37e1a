#include "beam_tree.h"

#include <superray/core/parallel.h>

#include <cmath>
#include <utility>

#include "walk_kernel.h"

namespace superray {
namespace {

/// Width of the narrowest beams at the end of a typical ray [cells].
static const double kNarrow = getenv("NARROW") ? atof(getenv("NARROW")) : 2;
/// Widest run there [cells]: wider ones would make all beams wide.
static const double kWidestRun = getenv("WRUN") ? atof(getenv("WRUN")) : 4;
/// Levels at most: bins are cleared and added up for every scan.
constexpr int kMostLevels = 6;

template <int Dim>
double typicalLength(const RayDirections<Dim>& directions) {
    const std::size_t rays = directions.kind.size(), step = rays / 256 + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < rays; i += step, ++n)
        sum += static_cast<double>(directions.length[i]);
    return sum / static_cast<double>(n);
}

/// Bits 0, 1, 2 .. of a number, 0 <= x < 256, to bits 0, 2, 4 ..
std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 4) & 0x0F0F;
    x = (x | x << 2) & 0x3333;
    return (x | x << 1) & 0x5555;
}

}  // namespace

template <int Dim>
void BeamTree<Dim>::find(const RayBundle<Dim>& rays, std::size_t shares) {
    static const FindDirections<Dim> findDirections = bestKernels<Dim>().findDirections;
    const std::size_t count = rays.size();
    directions_.resize(count);
    inParallel(shares, [&](std::size_t s) {
        findDirections(rays, shareBegin(count, s, shares), shareBegin(count, s + 1, shares),
                       directions_);
    });
    const double length = std::max(typicalLength(directions_), 1.0);
    widest_ = static_cast<float>(kWidestRun / length);
    levels_ = 0;
    // No more bins than rays.
    while (levels_ < kMostLevels && (1 << levels_) * kNarrow < length &&
           std::size_t{kKinds} << ((Dim - 1) * (levels_ + 1)) < count)
        ++levels_;

    if (runsOfShare_.size() < shares) runsOfShare_.resize(shares);
    if (startsOfShare_.size() < shares) startsOfShare_.resize(shares);
    inParallel(shares, [&](std::size_t s) {
        gather(shareBegin(count, s, shares), shareBegin(count, s + 1, shares), runsOfShare_[s]);
    });
    sort(shares);
}

/// Makes runs of consecutive rays: whole groups where these are narrow.
template <int Dim>
void BeamTree<Dim>::gather(std::size_t begin, std::size_t end, Runs& runs) const {
    static const BoundGroups<Dim> boundGroups = bestKernels<Dim>().boundGroups;
    constexpr std::size_t kAtOnce = GroupBounds<Dim>::kGroups * kGroupRays;
    runs.clear();
    GroupBounds<Dim> groups;
    for (; begin + kAtOnce <= end; begin += kAtOnce) {
        boundGroups(directions_, begin, groups);
        for (std::size_t g = 0; g < GroupBounds<Dim>::kGroups; ++g) {
            const std::size_t first = begin + g * kGroupRays;
            RayRun<Dim> run;
            bool narrow = groups.lowestKind[g] == groups.highestKind[g] &&
                          groups.lowestKind[g] != RayDirections<Dim>::kLone;
            for (int m = 0; m < Dim - 1; ++m) {
                run.low[m] = groups.low[m][g];
                run.high[m] = groups.high[m][g];
                run.reach[m] = groups.reach[m][g];
                narrow &= run.high[m] - run.low[m] <= widest_;
            }
            if (!narrow) {
                gatherOneByOne(first, first + kGroupRays, runs);
                continue;
            }
            run.length = groups.length[g];
            run.first = static_cast<std::uint32_t>(first);
            run.count = kGroupRays;
            run.kind = static_cast<std::uint16_t>(groups.lowestKind[g]);
            runs.push_back(run);
        }
    }
    gatherOneByOne(begin, end, runs);
}

/// The same, ray by ray.
template <int Dim>
void BeamTree<Dim>::gatherOneByOne(std::size_t begin, std::size_t end, Runs& runs) const {
    const RayDirections<Dim>& d = directions_;
    for (std::size_t i = begin; i < end;) {
        RayRun<Dim> run;
        run.first = static_cast<std::uint32_t>(i);
        run.kind = static_cast<std::uint16_t>(d.kind[i]);
        run.length = d.length[i];
        for (int m = 0; m < Dim - 1; ++m) {
            run.low[m] = run.high[m] = d.slope[m][i];
            run.reach[m] = d.slope[m][i] * d.length[i];
        }
        const std::size_t most =
            d.kind[i] == RayDirections<Dim>::kLone ? i + 1 : std::min(end, i + kGroupRays);
        for (++i; i < most && d.kind[i] == run.kind; ++i) {
            RayRun<Dim> more = run;
            bool narrow = true;
            for (int m = 0; m < Dim - 1; ++m) {
                const float s = d.slope[m][i];
                more.low[m] = std::min(run.low[m], s);
                more.high[m] = std::max(run.high[m], s);
                more.reach[m] = std::max(run.reach[m], s * d.length[i]);
                narrow &= more.high[m] - more.low[m] <= widest_;
            }
            if (!narrow) break;
            run = more;
            run.length = std::max(run.length, d.length[i]);
        }
        run.count = static_cast<std::uint16_t>(i - run.first);
        runs.push_back(run);
    }
}

/// Where a run belongs: kind and, interleaved, what its slopes are in the middle.
template <int Dim>
std::uint32_t BeamTree<Dim>::binOf(const RayRun<Dim>& run) const {
    const std::int32_t bins = 1 << levels_;
    const float half = 0.5f * static_cast<float>(bins);
    std::uint32_t bin = 0;
    for (int m = 0; m < Dim - 1; ++m) {
        const auto b = static_cast<std::int32_t>((run.low[m] + run.high[m]) * half);
        const auto within = static_cast<std::uint32_t>(std::clamp(b, 0, bins - 1));
        bin |= (Dim == 2 ? within : spread(within)) << m;
    }
    return (std::uint32_t{run.kind} << ((Dim - 1) * levels_)) + bin;
}

/// Counting sort; each share counts and places its own runs.
template <int Dim>
void BeamTree<Dim>::sort(std::size_t shares) {
    const std::size_t bins = std::size_t{kKinds} << ((Dim - 1) * levels_);
    inParallel(shares, [&](std::size_t s) {
        startsOfShare_[s].assign(bins, 0);
        for (const RayRun<Dim>& run : runsOfShare_[s]) ++startsOfShare_[s][binOf(run)];
    });
    starts_.resize(bins + 1);
    std::uint32_t start = 0;
    for (std::size_t b = 0; b < bins; ++b) {
        starts_[b] = start;
        for (std::size_t s = 0; s < shares; ++s)
            start += std::exchange(startsOfShare_[s][b], start);
    }
    starts_[bins] = start;
    runs_.resize(start);
    inParallel(shares, [&](std::size_t s) {
        for (const RayRun<Dim>& run : runsOfShare_[s])
            runs_[startsOfShare_[s][binOf(run)]++] = run;
    });
}

template <int Dim>
DirectionBounds<Dim> BeamTree<Dim>::bounds(const Node& n) const {
    DirectionBounds<Dim> all = runs_[n.first];
    for (std::uint32_t i = n.first + 1; i < n.last; ++i) all.include(runs_[i]);
    return all;
}

template class BeamTree<2>;
template class BeamTree<3>;

}  // namespace superray
