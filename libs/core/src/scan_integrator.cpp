#include <superray/core/culling_region.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/super_rays.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "end_cells.h"
#include "ray_walker.h"
#include "saturation_snapshot.h"

namespace superray {
namespace {

class Stopwatch {
 public:
    /// Seconds since construction or the last call.
    double lap() {
        const auto now = Clock::now();
        const double s = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return s;
    }

 private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point last_ = Clock::now();
};

/// Inclusive cell bounds of a scan: all origins and end points.
template <int Dim>
struct Extent {
    Cell<Dim> lowest, highest;
    explicit Extent(const RayBundle<Dim>& rays) {
        Point<Dim> low = rays.origin(0), high = low;
        const auto include = [&](const Point<Dim>& p) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        };
        for (std::size_t i = 0; i < rays.size(); ++i) include(rays.end(i));
        if (!rays.hasCommonOrigin())
            for (std::size_t i = 0; i < rays.size(); ++i) include(rays.origin(i));
        lowest = rays.geometry().cellOf(low);
        highest = rays.geometry().cellOf(high);
    }
    BlockBox<Dim> blocks() const { return {blockOf<Dim>(lowest), blockOf<Dim>(highest)}; }
};

/// Rays to one end cell: EndCells::order()[begin .. end), of which each
/// `every`-th is the selection that is walked first.
struct RayGroup {
    std::uint32_t begin, end, every;
};
enum class PartOfGroup { selection, rest };

/// One thread's part of a scan.
template <int Dim>
struct Share {
    EndCells<Dim> ends;  // of its rays
    std::vector<RayGroup> deferred;
    std::uint64_t culled = 0;
};

/// From this many rays per end cell on, the end cells themselves are worth a
/// look (a depth image at 5 cm has hundreds, at 2 cm ten; a spinning lidar at
/// 10 cm has 1 to 3).
constexpr std::size_t kDenseRaysPerEndCell = 32;

/// Runs work(share) for each share, the first in this thread.
template <typename Work>
void inParallel(std::size_t shares, const Work& work) {
    std::vector<std::exception_ptr> failures(shares);
    const auto guarded = [&](std::size_t share) {
        try {
            work(share);
        } catch (...) {
            failures[share] = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t share = 1; share < shares; ++share) threads.emplace_back(guarded, share);
    guarded(0);
    for (std::thread& t : threads) t.join();
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

/// Adds the counts of `from` to `to`. Saturating addition is associative and
/// commutative, so the result does not depend on how rays were shared out.
template <int Dim>
void mergeInto(WalkState<Dim>& to, const WalkState<Dim>& from) {
    const auto add = [](std::uint8_t* sum, const std::uint8_t* more) {
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            const unsigned s = unsigned{sum[i]} + more[i];
            sum[i] = static_cast<std::uint8_t>(s > 255 ? 255 : s);
        }
    };
    for (std::size_t b = 0; b < from.batch.blockCount(); ++b) {
        const std::uint32_t block = to.blockNumber(from.batch.key(b));
        add(to.batch.missesOf(block), from.batch.misses(b));
        if (from.batch.hits(b) != nullptr) add(to.batch.hitsOf(block), from.batch.hits(b));
    }
    to.traversed += from.traversed;
}

}  // namespace

Method methodFromString(const std::string& name) {
    for (Method m : {Method::reference, Method::perRay, Method::superRays, Method::culling,
                     Method::full, Method::automatic})
        if (name == toString(m)) return m;
    throw std::invalid_argument(
        "method = \"" + name +
        "\": must be reference, perRay, superRays, culling, full or auto");
}

const char* toString(Method method) {
    switch (method) {
        case Method::reference:
            return "reference";
        case Method::perRay:
            return "perRay";
        case Method::superRays:
            return "superRays";
        case Method::culling:
            return "culling";
        case Method::full:
            return "full";
        case Method::automatic:
            break;
    }
    return "auto";
}

void IntegratorOptions::validate() const {
    if (superRayThreshold < 1)
        throw std::invalid_argument("superRayThreshold = 0: must be >= 1");
    if (threads < 1 || threads > 1024)
        throw std::invalid_argument("threads = " + std::to_string(threads) +
                                    ": must be between 1 and 1024");
}

ScanStatistics& ScanStatistics::operator+=(const ScanStatistics& o) {
    rays += o.rays;
    superRays += o.superRays;
    traversedCells += o.traversedCells;
    raysCulled += o.raysCulled;
    cullingCells += o.cullingCells;
    touchedBlocks += o.touchedBlocks;
    superRaySeconds += o.superRaySeconds;
    cullingSeconds += o.cullingSeconds;
    traversalSeconds += o.traversalSeconds;
    return *this;
}

template <int Dim>
struct ScanIntegrator<Dim>::Impl {
    SuperRayGrouper<Dim> grouper;
    CullingRegion<Dim> region;
    SaturationSnapshot<Dim> snapshot;
    std::vector<WalkState<Dim>> states{1};  // one per share
    std::vector<Share<Dim>> shares{1};
    std::size_t shareCount = 1;
    ScanStatistics statistics;

    void walkSuperRays(const RayBundle<Dim>& rays, const std::vector<SuperRay>& superRays);
    void walkEach(const RayBundle<Dim>& rays);
    std::size_t walkSelection(const RayBundle<Dim>& rays, std::uint32_t walkedPerEndCell);
    void walkDeferred(const RayBundle<Dim>& rays);
    bool walkGroup(RayWalker<Dim>& walker, Share<Dim>& share, const RayBundle<Dim>& rays,
                   const RayGroup& group, PartOfGroup part) const;
};

template <int Dim>
ScanIntegrator<Dim>::ScanIntegrator() : impl_(std::make_unique<Impl>()) {}
template <int Dim>
ScanIntegrator<Dim>::~ScanIntegrator() = default;
template <int Dim>
ScanIntegrator<Dim>::ScanIntegrator(ScanIntegrator&&) noexcept = default;
template <int Dim>
ScanIntegrator<Dim>& ScanIntegrator<Dim>::operator=(ScanIntegrator&&) noexcept = default;

template <int Dim>
bool ScanIntegrator<Dim>::needsExactCounts(const IntegratorOptions& options,
                                           const SensorModel& model) {
    return options.method == Method::reference ||
           model.missesToSaturate() > UpdateBatch<Dim>::kMaxCount ||
           model.hitsToSaturate() > UpdateBatch<Dim>::kMaxCount;
}

template <int Dim>
const ScanStatistics& ScanIntegrator<Dim>::statistics() const {
    return impl_->statistics;
}

template <int Dim>
const UpdateBatch<Dim>& ScanIntegrator<Dim>::integrate(const RayBundle<Dim>& rays,
                                                       const SensorModel& model,
                                                       const IntegratorOptions& options,
                                                       const SaturationSource<Dim>* map) {
    options.validate();
    Impl& impl = *impl_;
    ScanStatistics& statistics = impl.statistics = {};
    statistics.rays = rays.size();
    if (rays.empty()) {
        impl.states[0].batch.clear();
        return impl.states[0].batch;
    }
    const Extent<Dim> extent(rays);
    const Method method = options.method;
    const bool grouping = method == Method::superRays || method == Method::full;
    const bool culling =
        method == Method::culling || method == Method::full || method == Method::automatic;
    // Shares large enough to repay a thread.
    const std::size_t shares = impl.shareCount =
        std::max<std::size_t>(1, std::min<std::size_t>(options.threads, rays.size() / 256));
    if (impl.states.size() < shares) {
        impl.states.resize(shares);
        impl.shares.resize(shares);
    }

    Stopwatch watch;
    const std::vector<SuperRay>* superRays = nullptr;
    if (grouping) superRays = &impl.grouper.group(rays, options.superRayThreshold);
    statistics.superRays = grouping ? superRays->size() : rays.size();
    inParallel(shares, [&](std::size_t s) {
        impl.states[s].reset(extent.blocks());
        impl.shares[s].ends.assign(rays, rays.size() * s / shares,
                                   rays.size() * (s + 1) / shares, extent.blocks());
        impl.shares[s].deferred.clear();
        impl.shares[s].culled = 0;
    });
    statistics.superRaySeconds = watch.lap();

    std::size_t endCells = 0;
    for (std::size_t s = 0; s < shares; ++s) endCells += impl.shares[s].ends.distinct();
    const bool dense = method == Method::automatic && rays.hasCommonOrigin() &&
                       rays.size() > kDenseRaysPerEndCell * endCells;

    impl.region.clear();
    if (dense) {
        impl.snapshot.assign(extent.blocks(), map, model.min());
    } else if (culling && map != nullptr) {
        const auto saturated = [&](const BlockKey<Dim>& key) {
            return map->saturatedFree(key, model.min());
        };
        impl.region.build(rays.geometry().cellOf(rays.commonOrigin()), extent.lowest,
                          extent.highest, saturated);
    }
    statistics.cullingSeconds = watch.lap();

    if (grouping) {
        impl.walkSuperRays(rays, *superRays);
    } else if (!dense) {
        impl.walkEach(rays);
    } else {
        // Misses of this scan after which more change nothing.
        const std::uint32_t enough =
            options.policy == UpdatePolicy::oncePerScan ? 1 : model.missesToSaturate();
        const std::size_t deferred = impl.walkSelection(rays, 2 * enough);
        statistics.traversalSeconds = watch.lap();
        if (deferred > 0)
            for (std::size_t s = 0; s < shares; ++s) impl.snapshot.add(impl.states[s], enough);
        statistics.cullingSeconds += watch.lap();
        if (deferred > 0) impl.walkDeferred(rays);
    }
    statistics.cullingCells = impl.region.cellCount();
    for (std::size_t s = 0; s < shares; ++s) {
        impl.shares[s].ends.addHits(impl.states[s]);
        statistics.raysCulled += impl.shares[s].culled;
        if (s > 0) mergeInto(impl.states[0], impl.states[s]);
    }
    statistics.traversalSeconds += watch.lap();
    statistics.traversedCells = impl.states[0].traversed;
    statistics.touchedBlocks = impl.states[0].batch.blockCount();
    return impl.states[0].batch;
}

template <int Dim>
void ScanIntegrator<Dim>::Impl::walkSuperRays(const RayBundle<Dim>& rays,
                                              const std::vector<SuperRay>& superRays) {
    inParallel(shareCount, [&](std::size_t s) {
        RayWalker<Dim> walker(states[s], rays, region);
        const std::size_t end = superRays.size() * (s + 1) / shareCount;
        for (std::size_t i = superRays.size() * s / shareCount; i < end; ++i)
            walker.walk(superRays[i].ray, superRays[i].weight);
        shares[s].culled = walker.culled();
    });
}

/// Walks every ray on its own, but not those whose end cell the region
/// encloses.
template <int Dim>
void ScanIntegrator<Dim>::Impl::walkEach(const RayBundle<Dim>& rays) {
    inParallel(shareCount, [&](std::size_t s) {
        Share<Dim>& share = shares[s];
        const bool culling = !region.empty() && rays.hasCommonOrigin();
        if (culling) share.ends.findEnclosed(region);
        RayWalker<Dim> walker(states[s], rays, region);
        const std::size_t end = rays.size() * (s + 1) / shareCount;
        for (std::size_t i = rays.size() * s / shareCount; i < end; ++i) {
            if (culling && share.ends.enclosed(i))
                ++share.culled;
            else
                walker.walk(i, 1);
        }
        share.culled += walker.culled();
    });
}

/// For scans with many rays per end cell. Rays to an end cell walk only the
/// slices in which their frustum has unsaturated cells; and of far more rays
/// than `walkedPerEndCell`, an even selection of about that many, which
/// saturates nearly all cells on the way: the others are deferred.
/// \return number of deferred rays
template <int Dim>
std::size_t ScanIntegrator<Dim>::Impl::walkSelection(const RayBundle<Dim>& rays,
                                                     std::uint32_t walkedPerEndCell) {
    std::vector<std::size_t> deferred(shareCount, 0);
    inParallel(shareCount, [&](std::size_t s) {
        Share<Dim>& share = shares[s];
        share.ends.sortByEndCell();
        const std::vector<std::uint32_t>& starts = share.ends.starts();
        RayWalker<Dim> walker(states[s], rays, region);
        for (std::size_t g = 0; g + 1 < starts.size(); ++g) {
            const std::uint32_t count = starts[g + 1] - starts[g];
            const std::uint32_t every = std::max(1u, count / walkedPerEndCell);
            const RayGroup group{starts[g], starts[g + 1], every};
            const bool more = walkGroup(walker, share, rays, group, PartOfGroup::selection);
            if (!more || every == 1) continue;
            share.deferred.push_back(group);
            deferred[s] += count - (count + every - 1) / every;
        }
    });
    std::size_t sum = 0;
    for (std::size_t d : deferred) sum += d;
    return sum;
}

template <int Dim>
void ScanIntegrator<Dim>::Impl::walkDeferred(const RayBundle<Dim>& rays) {
    inParallel(shareCount, [&](std::size_t s) {
        RayWalker<Dim> walker(states[s], rays, region);
        for (const RayGroup& group : shares[s].deferred)
            walkGroup(walker, shares[s], rays, group, PartOfGroup::rest);
    });
}

/// Walks a part of a group in the slices where its frustum is not saturated.
/// \return false if there are none (the whole group is done)
template <int Dim>
bool ScanIntegrator<Dim>::Impl::walkGroup(RayWalker<Dim>& walker, Share<Dim>& share,
                                          const RayBundle<Dim>& rays, const RayGroup& group,
                                          PartOfGroup part) const {
    const CellGeometry<Dim>& geometry = rays.geometry();
    const std::vector<std::uint32_t>& order = share.ends.order();
    const auto frustum =
        RayFrustum<Dim>::of(RayLine<Dim>::unitsOf(geometry, rays.commonOrigin()),
                            geometry.cellOf(rays.end(order[group.begin])));
    std::optional<SliceRange> range;
    if (frustum) range = frustum->unsaturated(snapshot);
    if (range && (range->from > 0 || range->empty())) share.culled += group.end - group.begin;
    if (range && range->empty()) return false;
    for (std::uint32_t i = group.begin; i < group.end; ++i) {
        const bool selected = (i - group.begin) % group.every == 0;
        if (selected != (part == PartOfGroup::selection)) continue;
        const RayLine<Dim> line(geometry, rays.commonOrigin(), rays.end(order[i]));
        walker.walk(line, range.value_or(SliceRange{0, line.slices()}), 1);
    }
    return true;
}

template class ScanIntegrator<2>;
template class ScanIntegrator<3>;

}  // namespace superray
