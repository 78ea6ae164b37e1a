// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_build.h
/// Recorded scans in, a map out, with progress and an account of what was done.

#include <mrpt/maps/CMetricMap.h>
#include <superray/eval/progress_meter.h>
#include <superray/eval/scan_source.h>
#include <superray/maps/insertion_report.h>
#include <superray/maps/super_ray_map_interface.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace superray {

/// What a build did.
struct BuildReport {
    std::uint64_t scans = 0;        ///< delivered by the inputs
    std::uint64_t unusable = 0;     ///< of those, without ranges or points that the map takes
    std::uint64_t tiltedScans = 0;  ///< planar ones that a 2D map leaves out
    std::string unreadable;         ///< why the first unusable scan is, where that is known
    SkippedObservations skipped;    ///< left out by the inputs
    TInsertionReport insertion;     ///< sums over all scans
    double readSeconds = 0;         ///< reading and decoding of the inputs
    double totalSeconds = 0;
    std::vector<std::string> poses;  ///< of each input, in words; see PoseSummary
    std::vector<std::string> warnings;
};

/// Inputs in the order they are mapped.
using ScanSources = std::vector<std::unique_ptr<ScanSource>>;

/// Where the rays of a scan start.
enum class ScanMotion : std::uint8_t {
    none,            ///< all at the scan's pose
    alongTrajectory  ///< each where the sensor was at its time: insertObservationAlong()
};

/// Inserts the scans of all inputs, one input after the other.
/// \param maxScans stop after so many scans
/// \param onScan called after every scan
/// \throws InputError if an input breaks, a scan cannot be inserted, none could be
///         used, or one that is to be de-skewed has no poses by time
BuildReport buildMap(const ScanSources& sources, mrpt::maps::CMetricMap& map,
                     std::uint64_t maxScans,
                     const std::function<void(const BuildProgress&)>& onScan,
                     ScanMotion motion = ScanMotion::none);

/// The account in lines of text, without the map's own numbers.
std::string describe(const BuildReport& report);

/// The account as one JSON object, with the map's cells and digest.
/// \param output path that the map was written to
std::string describeAsJson(const BuildReport& report, const SuperRayMapInterface& map,
                           const std::string& output);

}  // namespace superray
