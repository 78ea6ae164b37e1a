#include <superray/core/culling_region.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/super_rays.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "walk_kernel.h"

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
        lowest.fill(kCellLimit);
        highest.fill(-kCellLimit - 1);
        const auto include = [&](const Point<Dim>& p) {
            const Cell<Dim> c = rays.geometry().cellOf(p);
            for (int a = 0; a < Dim; ++a) {
                lowest[a] = std::min(lowest[a], c[a]);
                highest[a] = std::max(highest[a], c[a]);
            }
        };
        include(rays.origin(0));
        for (std::size_t i = 0; i < rays.size(); ++i) {
            include(rays.end(i));
            if (!rays.hasCommonOrigin()) include(rays.origin(i));
        }
    }
    BlockBox<Dim> blocks() const { return {blockOf<Dim>(lowest), blockOf<Dim>(highest)}; }
};

/// Addresses gathered before they are counted: enough to keep the counting
/// loop free of mispredictions, few enough to stay in the L1 cache.
constexpr std::size_t kFlushAt = 2048;

/// Walks rays[begin, end) into `state`.
template <int Dim>
void walkRays(WalkState<Dim>& state, const RayBundle<Dim>& bundle, const SuperRay* begin,
              const SuperRay* end, const CullingRegion<Dim>& region, std::uint64_t& culled) {
    static const WalkKernel<Dim> best = bestWalkKernel<Dim>();
    const WalkKernel<Dim> kernel = state.directory.dense() ? best : walkPortable<Dim>;
    std::uint32_t weight = 1;
    std::int32_t firstSlice = 0;
    for (const SuperRay* s = begin; s != end; ++s) {
        const RayLine<Dim> line(bundle.geometry(), bundle.origin(s->ray), bundle.end(s->ray));
        if (bundle.kind(s->ray) == RayEnd::hit) state.hit(line.endCell(), s->weight);
        if (s->weight != weight || state.addresses.size() >= kFlushAt) {
            state.flush(weight);
            weight = s->weight;
        }
        state.addresses.reserveMore(static_cast<std::size_t>(line.steps()));
        if (region.empty() || line.startCell() != region.sensor()) {
            kernel(state, line, 0);
        } else {
            firstSlice = region.firstSliceToWalk(line, firstSlice);
            culled += firstSlice > 0;
            kernel(state, line, firstSlice);
        }
    }
    state.flush(weight);
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
    std::vector<WalkState<Dim>> states{1};  // one per thread
    std::vector<SuperRay> single;           // every ray alone
    ScanStatistics statistics;
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

    Stopwatch watch;
    const std::vector<SuperRay>* walked = &impl.single;
    if (grouping) {
        walked = &impl.grouper.group(rays, options.superRayThreshold);
    } else {
        for (std::size_t i = impl.single.size(); i < rays.size(); ++i)
            impl.single.push_back({static_cast<std::uint32_t>(i), 1});
        impl.single.resize(rays.size());
    }
    statistics.superRays = walked->size();
    statistics.superRaySeconds = watch.lap();

    if (culling && map != nullptr) {
        const auto saturated = [&](const BlockKey<Dim>& key) {
            return map->saturatedFree(key, model.min());
        };
        impl.region.build(rays.geometry().cellOf(rays.commonOrigin()), extent.lowest,
                          extent.highest, saturated);
    } else {
        impl.region.clear();
    }
    statistics.cullingCells = impl.region.cellCount();
    statistics.cullingSeconds = watch.lap();

    // Shares large enough to repay a thread.
    const std::size_t shares =
        std::max<std::size_t>(1, std::min<std::size_t>(options.threads, walked->size() / 64));
    if (impl.states.size() < shares) impl.states.resize(shares);
    std::vector<std::uint64_t> culled(shares, 0);
    std::vector<std::exception_ptr> failures(shares);
    const auto walkShare = [&](std::size_t share) {
        try {
            const SuperRay* all = walked->data();
            impl.states[share].reset(extent.blocks());
            walkRays(impl.states[share], rays, all + walked->size() * share / shares,
                     all + walked->size() * (share + 1) / shares, impl.region, culled[share]);
        } catch (...) {
            failures[share] = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t share = 1; share < shares; ++share) threads.emplace_back(walkShare, share);
    walkShare(0);
    for (std::thread& t : threads) t.join();
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
    for (std::size_t share = 1; share < shares; ++share)
        mergeInto(impl.states[0], impl.states[share]);

    statistics.traversalSeconds = watch.lap();
    for (std::uint64_t c : culled) statistics.raysCulled += c;
    statistics.traversedCells = impl.states[0].traversed;
    statistics.touchedBlocks = impl.states[0].batch.blockCount();
    return impl.states[0].batch;
}

template class ScanIntegrator<2>;
template class ScanIntegrator<3>;

}  // namespace superray
