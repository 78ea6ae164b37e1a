// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/detail/parallel.h>

#include "engines/bench_engines.h"

namespace superray {
namespace {

/// As many independent maps as there are threads, each updated by one of them at the same
/// time: what threads could reach in one map on this machine, where they share nothing but
/// the processor and the memory.
class CopiesEngine final : public BenchEngine {
 public:
    CopiesEngine(const BenchEngineInfo& engine, const BenchEngineOptions& options) {
        BenchEngineOptions ofEach = options;
        ofEach.threads = 1;
        for (unsigned i = 0; i < options.threads; ++i) copies_.push_back(engine.make(ofEach));
    }

    void prepare(const PointScan& scan) override {
        for (const auto& copy : copies_) copy->prepare(scan);
    }
    void insert() override {
        inParallel(copies_.size(), [&](std::size_t i) { copies_[i]->insert(); });
    }
    BenchWork work() const override { return first().work(); }
    std::size_t mapBytes() const override {
        std::size_t bytes = 0;
        for (const auto& copy : copies_) bytes += copy->mapBytes();
        return bytes;
    }
    std::string digest() const override { return first().digest(); }
    std::optional<double> occupancy(const Eigen::Vector3f& point) const override {
        return first().occupancy(point);
    }
    const SaturationSource<3>* saturation() const override { return first().saturation(); }

 private:
    const BenchEngine& first() const { return *copies_.front(); }

    std::vector<std::unique_ptr<BenchEngine>> copies_;
};

}  // namespace

void listCopiesEngines(BenchEngineList& list) {
    for (const std::string name : {"grid", "octree"})
        list.push_back({name + "-copies", "as many maps of engine " + name + " as threads",
                        true, "", true, [name](const BenchEngineOptions& options) {
                            return std::make_unique<CopiesEngine>(benchEngine(name), options);
                        }});
}

}  // namespace superray
