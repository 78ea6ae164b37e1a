// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file bench_engine.h
/// What is compared with what: mapping engines, by name.

#include <superray/core/scan_integrator.h>
#include <superray/eval/point_scan.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace superray {

/// Which sensor model others' engines use. Ours have that of their policy.
enum class PeerModel : std::uint8_t {
    shared,  ///< SensorProbabilities: 0.7, 0.4, clamps 0.1192 and 0.971
    own      ///< the engine's defaults
};
const char* toString(PeerModel model);
/// \throws std::invalid_argument
PeerModel peerModelFromString(const std::string& name);

struct BenchEngineOptions {
    double resolution = 0.1;  ///< [m]
    unsigned threads = 1;
    UpdatePolicy policy = UpdatePolicy::netEvidence;
    /// Policy netEvidence of our maps only; nothing: their default.
    std::optional<double> scanMissMin;
    PeerModel peerModel = PeerModel::shared;
    std::uint32_t superRayThreshold = 20;
    /// Where the data are, for engines whose map has a fixed size [m].
    Eigen::AlignedBox3f bounds;
    /// [MB] of memory that our maps take before the first scan.
    std::uint32_t reserveMegabytes = 0;
};

/// What an engine tells about the last scan, or the sum over many. Zeros where
/// it does not tell.
struct BenchWork {
    double toRaysSeconds = 0, superRaySeconds = 0, cullingSeconds = 0, traversalSeconds = 0,
           applySeconds = 0;
    std::uint64_t rays = 0, superRays = 0, traversedCells = 0, cullingCells = 0,
                  touchedBlocks = 0;
    BenchWork& operator+=(const BenchWork& other);
};

/// The least probability at which a cell is taken to be occupied.
inline constexpr double kOccupiedFrom = 0.5;

/// A map and the way to update it.
class BenchEngine {
 public:
    virtual ~BenchEngine() = default;

    /// Puts a scan into the container that users of the engine have it in
    /// anyway. Not timed.
    virtual void prepare(const PointScan& scan) = 0;
    /// Updates the map with the prepared scan. Timed.
    virtual void insert() = 0;

    /// Work of the last insert().
    virtual BenchWork work() const { return {}; }
    /// Bytes of the map as the engine itself counts them.
    virtual std::size_t mapBytes() const = 0;
    /// contentDigest() of the map; empty if the engine has no such cells.
    virtual std::string digest() const { return {}; }
    /// Probability of being occupied; nothing where unknown.
    virtual std::optional<double> occupancy(const Eigen::Vector3f& point) const = 0;
    /// Which cells ignore misses, where the engine can tell.
    virtual const SaturationSource<3>* saturation() const { return nullptr; }
};

struct BenchEngineInfo {
    std::string name;
    std::string description;  ///< a line of text
    /// Exact engines must have equal digests for equal data, resolution and policy.
    bool exact = false;
    /// Of engines that have only one policy: its name. Empty: as requested.
    std::string ownPolicy;
    /// False: always uses one thread.
    bool threaded = false;
    std::function<std::unique_ptr<BenchEngine>(const BenchEngineOptions&)> make;
};

/// All engines: the built-in ones, and those added.
const std::vector<BenchEngineInfo>& benchEngines();
/// \throws InputError listing the names
const BenchEngineInfo& benchEngine(const std::string& name);
/// \throws std::invalid_argument if the name is taken
void addBenchEngine(BenchEngineInfo info);

}  // namespace superray
