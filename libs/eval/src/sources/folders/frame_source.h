// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file frame_source.h
/// Recordings that hold scans and no poses by time, as a file each or several in one: what
/// all of them share.

#include <superray/eval/scan_source.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sources/scan_source_formats.h"

namespace superray {

/// One scan that is not read yet.
struct Frame {
    std::filesystem::path file;
    Trajectory::Time time;  ///< mrpt::Clock::time_point() if the recording does not tell
    std::optional<mrpt::poses::CPose3D> T_map_robot;  ///< what the recording itself says
    std::size_t number = 0;                           ///< for read(), of files of many frames
    std::optional<std::size_t> row{};  ///< of this scan in a table: see frameNumber()
};

/// The frames of a recording, and how to read them.
struct FrameRecording {
    std::string path, label;
    std::vector<std::string> otherLabels;  ///< of sensors that are left out
    std::vector<Frame> frames;             ///< in the order of the recording, not empty
    PoseSummary ownPoses;                  ///< of T_map_robot, without times
    std::string warning;                   ///< see ScanSource::warning()
    /// Reads the points or the image of a frame; the rest is filled in. \throws InputError
    std::function<mrpt::obs::CObservation::Ptr(const Frame&)> read;
    bool guarded = false;  ///< read() lets another library decode: see ReadGuard
    /// The times are those of a clock; false: times tell nothing, as files have numbers only.
    bool isTimed = true;
};

/// With a poses file: by time, or, where the recording has no times, none fits, and there are
/// as many poses as frames, by order. A poses file of KITTI's 12 columns is by order too, or,
/// with more poses than frames, by the frames' rows.
/// \throws InputError if another label is asked for, no frame has a pose, or nothing tells
///         which pose belongs to which frame
std::unique_ptr<ScanSource> makeFrameSource(FrameRecording recording,
                                            const ScanSourceOptions& options);

/// The time that a file is named by: seconds, or a whole number of 16 digits [us] or 19
/// digits [ns], since 1970. Nothing for other names.
std::optional<Trajectory::Time> timeOfName(const std::string& stem);

/// The number of a frame that a file is named by, as KITTI does: the row of tables, counted
/// from 0. Nothing for other names, and for times.
std::optional<std::size_t> frameNumber(const std::string& stem);

/// Frames of files that are named by time, or by frame number.
void addNamedFrames(const std::vector<std::filesystem::path>& files, FrameRecording& recording);

/// \throws InputError if two frames have the same time, or are the same file but for its
///         extension
void refuseTwins(const FrameRecording& recording);

/// Files of the folder with one of these extensions (any case): by number where all names
/// are numbers, else by name, numbers in it by their values.
std::vector<std::filesystem::path> listFrames(const std::filesystem::path& folder,
                                              const std::vector<std::string>& extensions);

}  // namespace superray
