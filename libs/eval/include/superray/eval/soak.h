// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file soak.h
/// A drive without end: does a map with a sliding window keep to its memory?

#include <superray/eval/progress_meter.h>
#include <superray/eval/scan_source.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace superray {

struct SoakRequest {
    std::string data;  ///< see PointScanRequest
    ScanSourceOptions source;
    std::uint64_t worldSeed = 1;
    std::uint64_t insertions = 10000;  ///< scans to insert in all, >= 40
    std::vector<std::string> classes = {"CSuperRayGridMap3D"};  ///< see mapClassNames()
    double resolution = 0.2;                                    ///< [m]
    double windowRadius = 20;                                   ///< [m]; 0: no window
    std::uint32_t maxMemoryMegabytes = 0;                       ///< 0: no bound
    /// Evenly chosen of each scan; 0: all.
    std::size_t pointsPerScan = 20000;
    unsigned threads = 1;
    /// \throws InputError, std::invalid_argument
    void validate() const;
};

/// A look at the memory after so many scans.
struct SoakSample {
    std::uint64_t scans = 0;
    double scansPerSecond = 0;        ///< since the last sample
    std::uint64_t heldBytes = 0;      ///< see SuperRayMapInterface::heldBytes()
    std::uint64_t residentBytes = 0;  ///< of the process; 0 if it cannot be told
};

struct SoakRun {
    std::string className;
    std::vector<SoakSample> samples;  ///< kSoakSamples, evenly spread
    std::uint64_t scans = 0, forgottenBlocks = 0;
    double seconds = 0;
    double kilometres = 0;  ///< that the sensor went
};

/// Samples of a run; those before kSoakFilled are not judged, for the window fills.
inline constexpr std::size_t kSoakSamples = 40, kSoakFilled = 8;

/// Whether the highest of the values in the later half of those that are judged is within
/// 5 %, and `slack` bytes, of the highest in the earlier half.
bool isFlat(const std::vector<std::uint64_t>& values, std::uint64_t slack);
/// Both, the map's memory and that of the process.
bool isFlat(const SoakRun& run);

/// Inserts the scans of a recording again and again. Each lap begins where the last one
/// ended; near the limit of what can be addressed the drive turns, and comes back. Each
/// scan's likelihood is asked for before it is inserted, as a particle filter does.
std::vector<SoakRun> runSoak(const SoakRequest& request, std::ostream& log,
                             ProgressMeter::Style style);

std::string soakAsText(const SoakRequest& request, const std::vector<SoakRun>& runs);
std::string soakAsJson(const SoakRequest& request, const std::vector<SoakRun>& runs);

}  // namespace superray
