// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/culling_region.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/stopwatch.h>
#include <superray/core/super_rays.h>

#include <optional>
#include <stdexcept>

#include "directions/scan_bounds.h"
#include "paper/hit_cells.h"
#include "scan_walk.h"

namespace superray {

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
    /// Kept from scan to scan.
    struct Buffers {
        SuperRayGrouper<Dim> grouper;
        CullingRegion<Dim> region;
        ScanWalk<Dim> walk;
    };
    std::unique_ptr<Buffers> buffers;
    UpdateBatch<Dim> empty;
    ScanStatistics statistics;

    /// Calls `use(buffers)`. After an exception they may hold a part of its scan, so they are
    /// not used again.
    template <class Use>
    auto withBuffers(const Use& use) {
        if (!buffers) buffers = std::make_unique<Buffers>();
        try {
            return use(*buffers);
        } catch (...) {
            buffers.reset();
            throw;
        }
    }
};

template <int Dim>
ScanIntegrator<Dim>::ScanIntegrator() : impl_(std::make_unique<Impl>()) {}
template <int Dim>
ScanIntegrator<Dim>::~ScanIntegrator() = default;
template <int Dim>
ScanIntegrator<Dim>::ScanIntegrator(ScanIntegrator&&) noexcept = default;
template <int Dim>
ScanIntegrator<Dim>& ScanIntegrator<Dim>::operator=(ScanIntegrator&&) noexcept = default;

/// What settles a cell of a map (nullptr: none).
template <int Dim>
static SaturationLimits limitsFor(const IntegratorOptions& options, const SensorModel& model,
                                  const SaturationSource<Dim>* map) {
    return {model, options.policy, map != nullptr ? map->valueRange() : LogOddsRange{}};
}

template <int Dim>
bool ScanIntegrator<Dim>::needsExactCounts(const IntegratorOptions& options,
                                           const SensorModel& model,
                                           const SaturationSource<Dim>* map) {
    if (options.method == Method::reference) return true;
    // netEvidence cuts counts at 255 by definition, and oncePerScan at 1.
    if (options.policy != UpdatePolicy::everyRay) return false;
    const SaturationLimits limits = limitsFor<Dim>(options, model, map);
    return limits.misses > UpdateBatch<Dim>::kMaxCount ||
           limits.hits > UpdateBatch<Dim>::kMaxCount;
}

template <int Dim>
const ScanStatistics& ScanIntegrator<Dim>::statistics() const {
    return impl_->statistics;
}

template <int Dim>
void ScanIntegrator<Dim>::reserve(std::size_t bytes, unsigned threads) {
    IntegratorOptions options;
    options.threads = threads;
    options.validate();
    impl_->withBuffers([&](auto& buffers) { buffers.walk.reserve(bytes, threads); });
}

/// The culling region of a scan; empty if the method or the absence of a map wants none.
/// Under netEvidence, the misses of cells that are hit matter; the region leaves these out.
template <int Dim>
static void buildRegion(CullingRegion<Dim>& region, const RayBundle<Dim>& rays,
                        const ScanBounds<Dim>& bounds, const SensorModel& model,
                        const IntegratorOptions& options, const SaturationSource<Dim>* map) {
    region.clear();
    const Method method = options.method;
    if ((method != Method::culling && method != Method::full) || map == nullptr) return;
    std::optional<HitCells<Dim>> hits;
    if (options.policy == UpdatePolicy::netEvidence) hits.emplace(rays, bounds.blocks());
    BlockSaturation<Dim> block;
    const auto saturated = [&](const BlockKey<Dim>& key) {
        block = map->saturation(key, model.min());
        if (const BlockMask<Dim>* const hit = hits ? hits->in(key) : nullptr)
            for (int w = 0; w < BlockMask<Dim>::kWords; ++w)
                block.saturatedFree.words[w] &= ~hit->words[w];
        return block.saturatedFree.any() ? &block.saturatedFree : nullptr;
    };
    region.build(rays.geometry().cellOf(rays.commonOrigin()), bounds.lowest, bounds.highest,
                 saturated);
}

/// The counts of a scan that has rays. \param statistics what they cost: filled in
template <int Dim, class Buffers>
static const UpdateBatch<Dim>& countScan(const RayBundle<Dim>& rays, const SensorModel& model,
                                         const IntegratorOptions& options,
                                         const SaturationSource<Dim>* map, Buffers& buffers,
                                         ScanStatistics& statistics) {
    const ScanBounds<Dim> bounds(rays);
    const Method method = options.method;
    const bool grouping = method == Method::superRays || method == Method::full;
    const bool skipping = method == Method::automatic && rays.hasCommonOrigin();

    Stopwatch watch;
    const std::vector<SuperRay>* superRays = nullptr;
    if (grouping) {
        superRays = &buffers.grouper.group(rays, options.superRayThreshold);
        statistics.superRays = superRays->size();
    }
    statistics.superRaySeconds = watch.lap();

    CullingRegion<Dim>& region = buffers.region;
    buildRegion(region, rays, bounds, model, options, map);
    statistics.cullingCells = region.cellCount();
    statistics.cullingSeconds = watch.lap();

    const unsigned threads = options.threads;
    const typename ScanWalk<Dim>::Result result =
        grouping   ? buffers.walk.walkSuperRays(rays, bounds, threads, *superRays, region)
        : skipping ? buffers.walk.walkSkipping(rays, bounds, threads, map,
                                               limitsFor<Dim>(options, model, map))
                   : buffers.walk.walkEach(rays, bounds, threads, region);
    statistics.traversalSeconds = watch.lap();
    statistics.raysCulled = result.culled;
    statistics.traversedCells = result.counts.traversed;
    statistics.touchedBlocks = result.counts.batch.blockCount();
    return result.counts.batch;
}

template <int Dim>
const UpdateBatch<Dim>& ScanIntegrator<Dim>::integrate(const RayBundle<Dim>& rays,
                                                       const SensorModel& model,
                                                       const IntegratorOptions& options,
                                                       const SaturationSource<Dim>* map) {
    options.validate();
    ScanStatistics& statistics = impl_->statistics = {};
    statistics.rays = statistics.superRays = rays.size();
    if (rays.empty()) return impl_->empty;
    return *impl_->withBuffers([&](auto& buffers) {
        return &countScan(rays, model, options, map, buffers, statistics);
    });
}

template class ScanIntegrator<2>;
template class ScanIntegrator<3>;

}  // namespace superray
