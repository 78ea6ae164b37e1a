// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "sources/file_bytes.h"
#include "sources/folders/frame_source.h"
#include "sources/ros/ros_recording.h"
#include "sources/ros/ros_source.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

/// Whatever the case of its letters.
bool endsWith(const std::string& path, const std::string& end) {
    return path.size() >= end.size() &&
           equalIgnoringCase(path.substr(path.size() - end.size()), end);
}

bool hasFolder(const fs::path& folder, const char* name) {
    std::error_code error;
    return fs::is_directory(folder / name, error);
}

bool beginsWith(const std::string& path, const std::string& magic) {
    return startOfFile(path).rfind(magic, 0) == 0;
}

constexpr const char* kRgbdFolder = "RGB-D folder (TUM, ICL-NUIM)";

struct Format {
    const char* name;
    bool (*matches)(const std::string& path, bool isFolder);
    std::unique_ptr<ScanSource> (*open)(const std::string&, const ScanSourceOptions&);
};

/// The formats in the order they are tried.
constexpr std::array<Format, 14> kFormats{{
    {kRawlogFormat,
     [](const std::string& p, bool folder) {
         return !folder && (endsWith(p, ".rawlog") || endsWith(p, ".rawlog.gz"));
     },
     openRawlog},
    {"MRPT simplemap",
     [](const std::string& p, bool folder) {
         return !folder && (endsWith(p, ".simplemap") || endsWith(p, ".simplemap.gz"));
     },
     openSimpleMap},
    {"OctoMap scan graph",
     [](const std::string& p, bool folder) { return !folder && endsWith(p, ".graph"); },
     openScanGraph},
    {kRos1Format,
     [](const std::string& p, bool folder) {
         return !folder && (endsWith(p, ".bag") || endsWith(p, ".bag.active") ||
                            beginsWith(p, "#ROSBAG V"));
     },
     openRos},
    {kRos2Format,
     [](const std::string& p, bool folder) {
         return !folder && (endsWith(p, ".db3") || beginsWith(p, "SQLite format 3"));
     },
     openRos},
    {kMcapFormat,
     [](const std::string& p, bool folder) {
         return !folder && (endsWith(p, ".mcap") || beginsWith(p, "\x89MCAP"));
     },
     openRos},
    {kRos2Folder, [](const std::string& p, bool folder) { return folder && isBagFolder(p); },
     openRos},
    {"Velodyne capture (pcap)",
     [](const std::string& p, bool folder) {
         return !folder &&
                (endsWith(p, ".pcap") || endsWith(p, ".pcapng") || endsWith(p, ".cap"));
     },
     openVelodyneCapture},
    {"point cloud file (PCD, PLY, LAS)",
     [](const std::string& p, bool folder) {
         const auto extensions = cloudExtensions();
         return !folder && std::any_of(extensions.begin(), extensions.end(),
                                       [&](const auto& e) { return endsWith(p, e); });
     },
     openClouds},
    {"KITTI raw drive",
     [](const std::string& p, bool folder) {
         return folder && hasFolder(p, "velodyne_points");
     },
     [](const std::string& p, const ScanSourceOptions& o) { return openKittiRaw(p, o); }},
    {"KITTI odometry sequence",
     [](const std::string& p, bool folder) { return folder && hasFolder(p, "velodyne"); },
     [](const std::string& p, const ScanSourceOptions& o) { return openKitti(p, o); }},
    {kRgbdFolder,
     [](const std::string& p, bool folder) { return folder && hasFolder(p, "depth"); },
     [](const std::string& p, const ScanSourceOptions& o) { return openRgbd(p, o); }},
    {"folder of point clouds (PCD, PLY, LAS)",
     [](const std::string& p, bool folder) {
         return folder && !listFrames(p, cloudExtensions()).empty();
     },
     openClouds},
    {"folder of .bin scans named by time",
     [](const std::string& p, bool folder) {
         return folder && !listFrames(p, {".bin"}).empty();
     },
     [](const std::string& p, const ScanSourceOptions& o) { return openTimedBins(p, o); }},
}};

/// What an input looks like that is no known format, and what to do about it.
struct Hint {
    const char *extension, *advice;
};

constexpr std::array<Hint, 17> kHints{{
    {".db3.zstd", "a ROS 2 bag that is compressed: unpack it by 'zstd -d'"},
    {".mcap.zstd", "a ROS 2 bag that is compressed: unpack it by 'zstd -d'"},
    {".log", "a log, of CARMEN perhaps: convert it with MRPT's carmen2rawlog"},
    {".clf", "a CARMEN log: convert it with MRPT's carmen2rawlog"},
    {".e57", "an E57 cloud: convert it with 'pdal translate x.e57 x.ply'"},
    {".xyz", "a text cloud: convert it with 'pdal translate x.xyz x.ply'"},
    {".zip", "an archive: unpack it first"},
    {".tar", "an archive: unpack it first"},
    {".tgz", "an archive: unpack it first"},
    {".7z", "an archive: unpack it first"},
    {".bz2", "an archive: unpack it first"},
    {".xz", "an archive: unpack it first"},
    {".bt", "a map, not a recording: see superray-map info, export and compare"},
    {".ot", "a map, not a recording: see superray-map info, export and compare"},
    {".srmap", "a map, not a recording: see superray-map info, export and compare"},
    {".tum", "poses, not scans: give them with --poses"},
    {".gridmap", "a 2D map of MRPT, not a recording"},
}};

std::string adviceFor(const std::string& path, bool isFolder) {
    if (isFolder)
        return "a folder without scans of a known kind: it has no velodyne/*.bin (KITTI), "
               "depth/*.png (RGB-D), *.db3 or *.mcap (ROS 2), *.pcd, *.ply, *.las or *.bin";
    for (const Hint& hint : kHints)
        if (endsWith(path, hint.extension) ||
            endsWith(path, hint.extension + std::string(".gz")))
            return hint.advice;
    const std::string start = startOfFile(path);
    const auto begins = [&](const std::string& magic) { return start.rfind(magic, 0) == 0; };
    if (start.empty()) return "an empty file";
    if (begins("# .PCD") || begins("VERSION") || begins("ply\n"))
        return "a point cloud: name it .pcd or .ply";
    if (begins("\x1f\x8b") || begins("\x28\xb5\x2f\xfd"))
        return "compressed: unpack it, or name it so if it is a rawlog or simplemap";
    if (begins("LASF")) return "a LAS cloud: name it .las";
    for (const char* magic : {"\xd4\xc3\xb2\xa1", "\x4d\x3c\xb2\xa1", "\xa1\xb2\xc3\xd4",
                              "\xa1\xb2\x3c\x4d", "\x0a\x0d\x0d\x0a"})
        if (begins(magic)) return "a network capture: name it .pcap";
    const bool isText = std::all_of(start.begin(), start.end(), [](char c) {
        return std::isprint(static_cast<unsigned char>(c)) ||
               std::isspace(static_cast<unsigned char>(c));
    });
    return isText ? "a text file" : "a file of an unknown kind";
}

void checkDepthCamera(const DepthCamera& camera) {
    const auto require = [](bool rule, const char* name, double value, const char* text) {
        if (!rule) throw InputError(std::string(name) + " = " + formatValue(value) + text);
    };
    const auto isLength = [](double v) { return std::isfinite(v) && v > 0; };
    const char* const kLength = ": must be finite and > 0";
    require(isLength(camera.fx), "--intrinsics fx", camera.fx, kLength);
    require(isLength(camera.fy), "--intrinsics fy", camera.fy, kLength);
    // Beside the image, too: a part of a larger one.
    require(std::isfinite(camera.cx), "--intrinsics cx", camera.cx, ": must be finite");
    require(std::isfinite(camera.cy), "--intrinsics cy", camera.cy, ": must be finite");
    require(isLength(camera.unitsPerMetre), "--depth-units", camera.unitsPerMetre, kLength);
}

const Format& formatOf(const std::string& path) {
    std::error_code error;
    if (!fs::exists(path, error)) throw InputError(path + ": no such file or folder");
    const bool isFolder = fs::is_directory(path, error);
    if (!isFolder) requireRegularFile(path);
    for (const Format& format : kFormats)
        if (format.matches(path, isFolder)) return format;
    throw InputError(
        path + ": unknown input; it looks like " + adviceFor(path, isFolder) +
        ". Known are .rawlog, .simplemap, .graph (OctoMap), .bag, .db3 and .mcap "
        "(ROS), .pcd, .ply, .las, .pcap (Velodyne), and folders: ROS 2 bags, KITTI "
        "odometry and raw, TUM RGB-D, point clouds, .bin scans");
}

}  // namespace

bool isRosFormat(const std::string& name) {
    return name == kRos1Format || name == kRos2Format || name == kMcapFormat ||
           name == kRos2Folder;
}

std::string recordingFormat(const std::string& path) {
    return formatOf(path).name;
}

std::unique_ptr<ScanSource> openScanSource(const std::string& path,
                                           const ScanSourceOptions& options) {
    if (options.maxScans == 0) throw InputError("scans = 0: must be at least 1");
    if (!(options.maxPoseGap >= 0))
        throw InputError("the longest gap between poses is " + formatValue(options.maxPoseGap) +
                         " s: must be at least 0 s");
    checkDepthCamera(options.depthCamera);
    const Format& format = formatOf(path);
    if (!options.depthCamera.isDefault() && std::string(format.name) != kRgbdFolder)
        throw InputError(path + ": is a " + format.name +
                         ", which tells its cameras itself; --intrinsics and --depth-units are "
                         "for RGB-D folders");
    const bool hasLabels =
        std::string(format.name) == kRawlogFormat || isRosFormat(format.name);
    const bool asksLabelled = options.poses != PoseOrigin::input &&
                              options.poses != PoseOrigin::file &&
                              options.poses != PoseOrigin::fixed;
    if (asksLabelled && !hasLabels)
        throw InputError(path + ": has no choice of poses '" + toString(options.poses) +
                         "' (rawlogs and ROS recordings may have)");
    if (!options.poseLabel.empty() && !hasLabels)
        throw InputError(path + ": its poses have no labels, so '" + options.poseLabel +
                         "' is not among them (rawlogs and ROS recordings may have)");
    auto source = format.open(path, options);
    source->setMaxPoseGap(options.maxPoseGap);
    return source;
}

}  // namespace superray
