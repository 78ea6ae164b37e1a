// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file options.h
/// Options of the maps: public members, .ini sections, validation.
///
/// Loading is strict: an unknown key or a bad value throws
/// std::invalid_argument naming section, key, value and rule, and leaves the
/// options as they were. Absent keys keep their values.

#include <mrpt/config/CLoadableOptions.h>
#include <superray/core/ray_bundle.h>
#include <superray/core/scan_integrator.h>
#include <superray/core/sensor_model.h>

#include <cstdint>
#include <limits>
#include <string>

namespace superray {

/// Section `<map>_creationOpts`.
struct TCreationOptions : public mrpt::config::CLoadableOptions {
    double resolution = 0.10;  ///< cell edge [m], > 0
    /// Native map file (.srmap) to start from; empty: an empty map. Its
    /// resolution replaces `resolution`; its options are not used.
    std::string load_from;
    /// Folder of externally stored (lazy-load) observations, usually
    /// `<rawlog name>_Images`; empty: as the program says. MRPT has one such folder per
    /// process: it is set when the options are, and is not kept with the map.
    std::string lazy_load_path;
    /// [MB], at most 1048576: memory taken from the system, and touched, when the map is
    /// made and whenever it is cleared, so that the first scans of a robot that must
    /// keep up do not wait for it: a quarter of it for the counts of a scan, the rest
    /// for the map. Each copy that is cleared has its own. 0: none.
    std::uint32_t reserve_megabytes = 0;
    /// [MB], at most 1048576 and at least reserve_megabytes: the memory that cells, point
    /// statistics and points of a points map may hold together. Before a scan, a merge or
    /// a file would take the map beyond it, MemoryLimitError is thrown, and the map stays
    /// as it was. A map that is loaded keeps the tighter one of this bound and its own.
    /// 0: none. See doc/reliability.md.
    std::uint32_t max_memory_megabytes = 0;
    bool enableSaveAs3DObject = true;         ///< MRPT: visualisation on
    bool enableObservationLikelihood = true;  ///< MRPT: likelihood on
    bool enableObservationInsertion = true;   ///< MRPT: insertion on

    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /// \throws std::invalid_argument naming the option, its value and the rule
    void validate() const;
};

/// Section `<map>_insertOpts`. Names that COctoMap has mean what they mean there.
struct TInsertionOptions : public mrpt::config::CLoadableOptions {
    double maxrange = -1;  ///< [m] longer rays are cut and clear only; <= 0: no limit
    double minrange = 0;   ///< [m] nearer returns are skipped
    // The probabilities are those of the default policy; see setPolicy() and
    // loadFromConfigFile().
    double probHit = 0.9;     ///< in (0.5, 1): what one hit says
    double probMiss = 0.475;  ///< in (0, 0.5): what one miss says
    /// Policy netEvidence only: the most that one scan makes of an unknown cell, in (0.5, 1)
    /// and in (0, 0.5). For a static world, scanMissMin = 0.4 keeps more thin surfaces.
    double scanHitMax = 0.9;
    double scanMissMin = 0.293;
    double clampingThresMin = 0.293;  ///< lowest probability of a cell, in (0, 0.5)
    double clampingThresMax = 0.971;  ///< highest probability of a cell, in (0.5, 1)
    double occupancyThres = 0.5;      ///< occupied from this probability on, in (0, 1)
    /// netEvidence keeps surfaces that few of the rays end in; everyRay is the paper's rule,
    /// oncePerScan OctoMap's (doc/accuracy.md).
    UpdatePolicy policy = UpdatePolicy::netEvidence;
    Method method = Method::automatic;  ///< all give the same map
    std::uint32_t superRayThreshold = 20;
    std::uint32_t threads = 1;        ///< >= 1; the map does not depend on it
    std::uint32_t decimation = 1;     ///< >= 1; use one of so many measurements
    bool insertNoReturnRays = false;  ///< measurements without return clear space
    double noReturnRange = 0;  ///< [m] length of such rays; <= 0: the sensor's maximum range
    /// [s], >= 0: from the first ray of a 2D scan to its last; the time stamp is
    /// that of the first. Used by insertObservationAlong() only.
    double sweepDuration = 0;
    std::string sensorLabel;  ///< comma-separated labels to accept; empty: all
    /// [degrees], in [0, 90]: 2D maps leave out planar scans whose plane is tilted by more.
    /// 3D maps take them all.
    double horizontalTolerance = 5;
    /// A ray that is cut at maxrange clears the cell of the cut, too (unless its return lies
    /// in it). Without, that cell is left alone, as OctoMap does.
    bool clearAtMaxrange = false;
    /// [m], map frame: only returns with a height in [heightBandMin, heightBandMax] are
    /// inserted. In 2D maps a ray of a 3D sensor clears what it crosses inside the band,
    /// wherever it ends; and of a cell in which a return of the same scan lies it tells
    /// nothing. See doc/exactness.md.
    double heightBandMin = -std::numeric_limits<double>::infinity();
    double heightBandMax = std::numeric_limits<double>::infinity();
    /// [m], >= 0: after each scan, blocks of 8 cells per axis that are farther from the
    /// sensor are forgotten: their cells are unknown again. 0: none are. What is within
    /// this distance always stays. See doc/exactness.md for the exact rule.
    double windowRadius = 0;
    /// Keep number, mean and covariance of the end points in each cell, so that
    /// matching knows where the surface lies in it (costs time and memory).
    bool pointStatistics = false;

    /// Chooses a policy, and the probabilities that suit it: probHit, probMiss and
    /// clampingThresMin are 0.9, 0.475 and 0.293 for netEvidence, 0.7, 0.4 and 0.1192 for the
    /// others. To have other ones, set them afterwards.
    void setPolicy(UpdatePolicy policy);

    /// Absent keys keep their values, but: if `policy` changes, the probabilities become those
    /// of setPolicy() where they are absent. If `probHit` or `probMiss` is given and
    /// `policy` is not, they are taken for those of an OctoMap configuration, and the policy
    /// becomes oncePerScan, which gives OctoMap's map.
    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /// \throws std::invalid_argument naming the option, its value and the rule
    void validate() const;

    // What the engine needs, each validated.
    SensorModel sensorModel() const;
    RangeLimits rangeLimits() const;
    IntegratorOptions integratorOptions() const;
    /// True if `label` is in sensorLabel, or that is empty.
    bool acceptsSensor(const std::string& label) const;
};

/// What a scan does to a cell, in a line: policy and probabilities.
std::string describeRule(const TInsertionOptions& options);

/// Section `<map>_likelihoodOpts`: end-point model. A return scores
/// log((1 - w) exp(-d^2 / (2 sigma^2)) + w), with d the distance from its end
/// point to the nearest occupied cell, cut at maxDistance, and w = uniformWeight;
/// the log-likelihood is the sum.
struct TLikelihoodOptions : public mrpt::config::CLoadableOptions {
    std::uint32_t decimation = 1;  ///< >= 1; use one of so many measurements
    double sigma = 0.1;            ///< [m], 1e-6 to 1e6
    /// [m], 1e-6 to 1e6; farther is as bad as this. At most 31 cells are looked at.
    double maxDistance = 0.3;
    /// In [0, 1): share of returns that may be anywhere (people, glass); the
    /// larger, the less a single one can spoil a pose. 0: none.
    double uniformWeight = 0;
    /// In (0, 1]: factor for a return that ends in unknown space with nothing
    /// occupied near it, where a hit has 1.
    double unknownLikelihood = 0.1;

    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
    /// \throws std::invalid_argument naming the option, its value and the rule
    void validate() const;
};

enum class VoxelColour : std::uint8_t { height, occupancy };

/// Section `<map>_renderOpts`.
struct TRenderingOptions : public mrpt::config::CLoadableOptions {
    bool generateGridLines = false;
    bool generateOccupiedVoxels = true;
    bool visibleOccupiedVoxels = true;
    /// Off, unlike COctoMap: free cells are many and hide the others.
    bool generateFreeVoxels = false;
    bool visibleFreeVoxels = true;
    VoxelColour colour = VoxelColour::height;

    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
};

/// All options of a map.
struct TMapOptions {
    TCreationOptions creation;
    TInsertionOptions insertion;
    TLikelihoodOptions likelihood;
    TRenderingOptions rendering;

    /// \throws std::invalid_argument naming the option, its value and the rule
    void validate() const;

    /// Sections `<prefix>_creationOpts`, `_insertOpts`, `_likelihoodOpts` and
    /// `_renderOpts`; absent ones are left alone.
    /// \throws std::invalid_argument also for any other section `<prefix>_...`
    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& prefix);

    /// Sections [creationOpts], [insertOpts], ... with every option. Numbers
    /// are written so that they read back to the same bits.
    /// \throws std::invalid_argument if a text has a control character
    std::string toText() const;
    /// Inverse of toText(). Absent keys keep their values.
    /// \throws std::invalid_argument for a text that toText() does not write
    void fromText(const std::string& text);
};

}  // namespace superray
