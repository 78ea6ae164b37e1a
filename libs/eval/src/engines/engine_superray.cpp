// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>

#include "engines/bench_engines.h"

namespace superray {
namespace {

/// One of our maps, used as a program that embeds it does: points to rays
/// (timed), rays into the map.
template <class Map>
class SuperrayEngine final : public BenchEngine {
 public:
    SuperrayEngine(const BenchEngineOptions& options, Method method)
        : map_(options.resolution), geometry_(options.resolution) {
        map_.insertionOptions.method = method;
        map_.insertionOptions.setPolicy(options.policy);
        if (options.scanMissMin) map_.insertionOptions.scanMissMin = *options.scanMissMin;
        map_.insertionOptions.threads = options.threads;
        map_.insertionOptions.superRayThreshold = options.superRayThreshold;
        TMapOptions reserving = map_.options();
        reserving.creation.reserve_megabytes = options.reserveMegabytes;
        map_.setOptions(reserving);
    }

    void prepare(const PointScan& scan) override { scan_ = &scan; }
    void insert() override {
        const Stopwatch watch;
        rays_.restart(scan_->origin.cast<double>());
        rays_.addReturns(scan_->points.data()->data(), scan_->points.size(),
                         map_.insertionOptions.threads);
        toRaysSeconds_ = watch.seconds();
        map_.insertRays(rays_);
    }
    BenchWork work() const override {
        const TInsertionReport& report = map_.lastInsertion();
        BenchWork work;
        work.toRaysSeconds = toRaysSeconds_;
        work.superRaySeconds = report.work.superRaySeconds;
        work.cullingSeconds = report.work.cullingSeconds;
        work.traversalSeconds = report.work.traversalSeconds;
        work.applySeconds = report.applySeconds;
        work.rays = report.rays;
        work.superRays = report.work.superRays;
        work.traversedCells = report.work.traversedCells;
        work.cullingCells = report.work.cullingCells;
        work.touchedBlocks = report.work.touchedBlocks;
        return work;
    }
    std::size_t mapBytes() const override { return map_.memoryBytes(); }
    std::string digest() const override { return map_.digest(); }
    std::optional<double> occupancy(const Eigen::Vector3f& p) const override {
        const Point<3> point = p.cast<double>();
        if (!geometry_.contains(point)) return std::nullopt;
        const auto value = map_.storage().logOdds(geometry_.cellOf(point));
        if (!value) return std::nullopt;
        return probabilityOf(*value);
    }
    const SaturationSource<3>* saturation() const override { return &map_.storage(); }

 private:
    Map map_;
    CellGeometry<3> geometry_;
    RayBundle<3> rays_{geometry_, Point<3>::Zero()};  // keeps its memory
    const PointScan* scan_ = nullptr;
    double toRaysSeconds_ = 0;
};

template <class Map>
void listMap(BenchEngineList& list, const std::string& name, const std::string& what) {
    for (const Method method : {Method::automatic, Method::perRay, Method::superRays,
                                Method::culling, Method::full, Method::reference}) {
        const std::string suffix =
            method == Method::automatic ? "" : std::string("-") + toString(method);
        list.push_back({name + suffix, what + ", method " + toString(method), true, "", true,
                        [method](const BenchEngineOptions& options) {
                            return std::make_unique<SuperrayEngine<Map>>(options, method);
                        }});
    }
}

}  // namespace

void listSuperrayEngines(BenchEngineList& list) {
    listMap<CSuperRayGridMap3D>(list, "grid", "CSuperRayGridMap3D");
    listMap<CSuperRayOctoMap>(list, "octree", "CSuperRayOctoMap");
}

}  // namespace superray
