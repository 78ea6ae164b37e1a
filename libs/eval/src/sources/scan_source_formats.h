// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scan_source_formats.h
/// What the readers of the single formats share.

#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>
#include <superray/eval/trajectory.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace superray {

std::unique_ptr<ScanSource> openRawlog(const std::string& path, const ScanSourceOptions&);
std::unique_ptr<ScanSource> openSimpleMap(const std::string& path, const ScanSourceOptions&);
std::unique_ptr<ScanSource> openScanGraph(const std::string& path, const ScanSourceOptions&);
std::unique_ptr<ScanSource> openVelodyneCapture(const std::string& path,
                                                const ScanSourceOptions&);
std::unique_ptr<ScanSource> openClouds(const std::string& path, const ScanSourceOptions&);
std::unique_ptr<ScanSource> openKitti(const std::filesystem::path& folder,
                                      const ScanSourceOptions&);
std::unique_ptr<ScanSource> openKittiRaw(const std::filesystem::path& folder,
                                         const ScanSourceOptions&);
std::unique_ptr<ScanSource> openRgbd(const std::filesystem::path& folder,
                                     const ScanSourceOptions&);
std::unique_ptr<ScanSource> openTimedBins(const std::filesystem::path& folder,
                                          const ScanSourceOptions&);

/// Extensions of the files that openClouds() takes, also in a folder.
std::vector<std::string> cloudExtensions();

inline constexpr const char* kRawlogFormat = "MRPT rawlog";
inline constexpr const char* kRos1Format = "ROS 1 bag";
inline constexpr const char* kRos2Format = "ROS 2 bag (SQLite)";
inline constexpr const char* kMcapFormat = "MCAP (ROS)";
inline constexpr const char* kRos2Folder = "folder of a ROS 2 bag";

/// True for the names of ROS formats.
bool isRosFormat(const std::string& name);

/// What an input is, by its name and contents, e.g. kRawlogFormat.
/// \throws InputError if there is nothing, or nothing that is known: says what it looks
///         like, and how to convert it
std::string recordingFormat(const std::string& path);

/// True for the observations that become rays: laser, depth and point scans.
bool isRangeObservation(const mrpt::obs::CObservation& observation);

/// True if the options ask for the sensor.
bool acceptsLabel(const ScanSourceOptions& options, const std::string& label);

/// True if a range observation is wanted; counts it as skipped if it is not.
bool hasWantedLabel(const mrpt::obs::CObservation& observation,
                    const ScanSourceOptions& options, SkippedObservations& skipped);

/// Robot poses as the options ask for: replaces what the input says.
class PoseLookup {
 public:
    /// \throws InputError if the poses file cannot be used
    explicit PoseLookup(const ScanSourceOptions& options);

    bool usesInput() const {
        return origin_ == PoseOrigin::input || origin_ == PoseOrigin::odometry;
    }
    /// Poses of the poses file; nullptr without.
    const Trajectory* fromFile() const {
        return origin_ == PoseOrigin::file ? &trajectory_ : nullptr;
    }
    /// The poses in words.
    /// \param firstScan time stamp of the first scan
    /// \param fromInput what the input itself has
    PoseSummary summary(Trajectory::Time firstScan, const PoseSummary& fromInput) const;

    /// The robot pose for a scan.
    /// \param fromInput what the input itself says
    PoseAnswer pose(Trajectory::Time time,
                    const std::optional<mrpt::poses::CPose3D>& fromInput) const;

 private:
    PoseOrigin origin_;
    std::string file_;
    PoseLimits limits_;
    Trajectory trajectory_;
};

/// What to do with an input whose end cannot be read.
/// \param scans before the break
/// \return the warning, if the options accept it, and there are any
/// \throws InputError
std::string acceptBreak(const InputError& error, std::uint64_t scans,
                        const ScanSourceOptions& options);

/// Counts a scan that has no pose.
void countWithoutPose(const PoseAnswer& answer, SkippedObservations& skipped);

/// The error of an input of which no scan has a pose.
/// \param path of the input
/// \param poses those by time that were used; nullptr if there are none
[[noreturn]] void throwNoScanHasPose(const std::string& path, const ScanSourceOptions& options,
                                     Trajectory::Time firstScan, Trajectory::Time lastScan,
                                     const PoseTrack* poses);

/// The error of an input without scans, naming the label that was asked for.
/// \param labels those that there are, for people
[[noreturn]] void throwNoScans(const std::string& path, const ScanSourceOptions& options,
                               const SkippedObservations& skipped,
                               const std::string& labels = {});

}  // namespace superray
