// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scan_integrator.h
/// Scan in, update batch out: the one entry point of the engine.

#include <superray/core/ray_bundle.h>
#include <superray/core/saturation_source.h>
#include <superray/core/sensor_model.h>
#include <superray/core/update_batch.h>

#include <cstdint>
#include <memory>
#include <string>

namespace superray {

/// How the batch is computed. All give the same map, bit for bit.
enum class Method : std::uint8_t {
    reference,  ///< one ray, one cell at a time, into a hash map (the oracle)
    perRay,     ///< every ray walked into the batch
    superRays,  ///< rays grouped into super rays first (paper Sec. IV-A)
    culling,    ///< walks end at the culling region (paper Sec. IV-B)
    full,       ///< super rays and culling region
    automatic   ///< chosen by measurement per scan ("auto")
};
Method methodFromString(const std::string& name);  ///< \throws std::invalid_argument
const char* toString(Method method);

struct IntegratorOptions {
    Method method = Method::automatic;
    UpdatePolicy policy = UpdatePolicy::everyRay;
    /// Super-ray threshold k: end cells with fewer points are not grouped
    /// (paper Sec. IV-A3; its experiments use 20).
    std::uint32_t superRayThreshold = 20;
    /// Threads that walk rays; >= 1, and more than processors do not help. The result
    /// does not depend on it.
    unsigned threads = 1;
    /// \throws std::invalid_argument naming the option and the rule
    void validate() const;
};

/// Work done for one scan (paper Table III, Fig. 12).
struct ScanStatistics {
    std::uint64_t rays = 0;            ///< rays in the bundle
    std::uint64_t superRays = 0;       ///< rays walked after grouping
    std::uint64_t traversedCells = 0;  ///< free cells visited
    std::uint64_t raysCulled = 0;      ///< rays cut short or left out: the rest is saturated
    std::uint64_t cullingCells = 0;    ///< cells in the culling region
    std::uint64_t touchedBlocks = 0;
    double superRaySeconds = 0, cullingSeconds = 0, traversalSeconds = 0;
    ScanStatistics& operator+=(const ScanStatistics& o);
};

/// Turns scans into update batches. Keeps buffers between scans: one instance
/// per map; not thread-safe (it runs its own threads).
template <int Dim>
class ScanIntegrator {
 public:
    ScanIntegrator();
    ~ScanIntegrator();
    ScanIntegrator(ScanIntegrator&&) noexcept;
    ScanIntegrator& operator=(ScanIntegrator&&) noexcept;

    /// True if a scan must go through countCells() instead of integrate(): for method
    /// `reference`, and for policy everyRay where the clamps, or the values in the map, lie
    /// more than 255 updates apart.
    /// \param map nullptr: none
    static bool needsExactCounts(const IntegratorOptions& options, const SensorModel& model,
                                 const SaturationSource<Dim>* map);

    /// Counts of a scan in blocks. The reference stays valid until the next call.
    /// \param map current saturation of the map; may be nullptr (then no
    ///        culling by map contents)
    /// \pre !needsExactCounts(options, model, map)
    /// \throws std::bad_alloc, std::length_error (more than 2^32 cells): then buffers, and
    ///         what reserve() took, are given back, and a later scan is not affected
    const UpdateBatch<Dim>& integrate(const RayBundle<Dim>& rays, const SensorModel& model,
                                      const IntegratorOptions& options,
                                      const SaturationSource<Dim>* map);

    /// Takes about so many bytes from the system for the counts of scans, and touches
    /// them, so that the first scans need not wait for page faults. What integrate()
    /// returned is not valid any longer.
    /// \param threads as in the options of scans to come
    /// \throws std::bad_alloc, std::invalid_argument as IntegratorOptions::validate()
    void reserve(std::size_t bytes, unsigned threads);

    /// Statistics of the last integrate().
    const ScanStatistics& statistics() const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

extern template class ScanIntegrator<2>;
extern template class ScanIntegrator<3>;

}  // namespace superray
