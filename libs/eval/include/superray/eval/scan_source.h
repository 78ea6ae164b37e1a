// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file scan_source.h
/// Recorded scans with the robot's pose, from any of the formats we read.

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>
#include <superray/eval/pose_origin.h>
#include <superray/eval/trajectory.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace superray {

/// One observation of a range sensor, and where the robot was.
struct Scan {
    mrpt::Clock::time_point timestamp;  ///< mrpt::Clock::time_point() if unknown
    mrpt::poses::CPose3D T_map_robot;
    mrpt::obs::CObservation::Ptr observation;
};

/// What to do with an input that ends in the middle of an object, or of its compressed
/// data. An input that is damaged in another way is always refused.
enum class Truncation : std::uint8_t {
    error,  ///< refuse the input (before any scan is delivered)
    accept  ///< deliver the scans before the break
};

/// Pinhole camera of depth images that come without (RGB-D folders). The default is what
/// the TUM RGB-D benchmark recommends.
struct DepthCamera {
    double fx = 525, fy = 525, cx = 319.5, cy = 239.5;  ///< [pixels]
    double unitsPerMetre = 5000;                        ///< of the values in the images

    /// The images that the default is of.
    static constexpr std::uint32_t kDefaultColumns = 640, kDefaultRows = 480;
    /// Nobody said what the camera is.
    bool hasDefaultIntrinsics() const {
        const DepthCamera d;
        return fx == d.fx && fy == d.fy && cx == d.cx && cy == d.cy;
    }
    bool isDefault() const {
        return hasDefaultIntrinsics() && unitsPerMetre == DepthCamera().unitsPerMetre;
    }
};

struct ScanSourceOptions {
    PoseOrigin poses = PoseOrigin::input;
    std::string posesFile;  ///< with PoseOrigin::file; see Trajectory::load()
    /// Comma-separated labels of the poses to use (rawlogs, ROS): one of a kind; empty: any,
    /// if there is only one.
    std::string poseLabel;
    double maxPoseGap = kDefaultPoseGap;  ///< [s] see PoseLimits::maxGap
    std::string sensorLabel;              ///< comma-separated labels to deliver; empty: all
    Truncation truncation = Truncation::error;
    DepthCamera depthCamera;
    /// Deliver at most so many scans.
    std::uint64_t maxScans = std::numeric_limits<std::uint64_t>::max();
};

/// Observations that did not become scans, and why.
struct SkippedObservations {
    std::uint64_t otherLabel = 0;   ///< range observations of another label
    std::uint64_t withoutPose = 0;  ///< outside the time range of the poses
    std::uint64_t inPoseGap = 0;    ///< between poses that are too far apart in time
    std::uint64_t withoutTime = 0;  ///< no time stamp, where poses are by time
    std::uint64_t badPoses = 0;     ///< robot poses that are not finite

    SkippedObservations& operator+=(const SkippedObservations& o) {
        otherLabel += o.otherLabel;
        withoutPose += o.withoutPose;
        inPoseGap += o.inPoseGap;
        withoutTime += o.withoutTime;
        badPoses += o.badPoses;
        return *this;
    }
};

/// A stream of scans. Inputs are read one scan at a time where the format
/// allows it (all but .simplemap).
///
/// Use sources one after the other: MRPT has one folder, process-wide, for
/// externally stored observations, and each source sets it to its own.
class ScanSource {
 public:
    virtual ~ScanSource() = default;

    /// The next scan; nothing at the end.
    /// \throws InputError
    virtual std::optional<Scan> next() = 0;

    /// Scans that next() will deliver in all (known from a first pass).
    virtual std::uint64_t total() const = 0;

    virtual SkippedObservations skipped() const = 0;

    /// Robot poses by time, from which those of the scans are; nullptr if the input
    /// has none (increments, a fixed robot, or scans without times).
    virtual const PoseTrack* trajectory() const { return nullptr; }

    /// The longest time between two of them that is bridged [s].
    double maxPoseGap() const { return maxPoseGap_; }

    /// Which poses are used, and what is known of them.
    virtual PoseSummary poses() const { return {}; }

    /// A break in the input that Truncation::accept let pass; else empty.
    virtual std::string warning() const { return {}; }

    /// Labels of its sensors of ranges, also of those that are not delivered.
    virtual std::vector<std::string> sensorLabels() const { return {}; }

    /// Set by openScanSource().
    void setMaxPoseGap(double seconds) { maxPoseGap_ = seconds; }

 private:
    double maxPoseGap_ = kDefaultPoseGap;
};

/// Opens an input by its extension or contents. MRPT's files may be gzip, zstd or
/// plain inside, whatever their names; see CompressedInput and readObject().
///
///  - `.rawlog`: observations, or action/observation pairs. For the robot poses see
///    PoseOrigin; those by time hold for 50 ms outside their range, and are interpolated
///    over at most maxPoseGap. Poses and scans whose time stamps are invalid, or mostly
///    equal, are paired by their order. Externally stored observations are looked for in
///    `<name>_Images` or `Images` beside the rawlog, in any case of letters, and beside it.
///  - `.simplemap`, `.simplemap.gz`: mean pose of each keyframe.
///  - `.graph`: OctoMap's ScanGraph; becomes CObservationPointCloud at the
///    node's pose.
///  - `.bag` (ROS 1), `.db3` (ROS 2), `.mcap`, or a folder of ROS 2: PointCloud2, LaserScan,
///    and depth images with CameraInfo; labels are topics. Time stamps are those of the
///    headers. The robot is base_link, base_footprint, or the child of an odometry; its poses
///    are the root of /tf ("tf map"), topics of poses, odometry topics, and frames between
///    ("tf odom", odometry). Sensors are where the transforms say.
///  - `.pcap`: a network capture of a Velodyne (VLP-16, HDL-32E), a scan a revolution, with
///    the time of capture; with a poses file, or fixed. Label `VELODYNE`, or, of several
///    sensors, `VELODYNE_<address>_<port>`, of which one must be chosen.
///  - `.pcd`, `.ply`, `.las`, or a folder of them: a scan each, in the order of their names.
///    Names that are times (seconds, or digits of micro- or nanoseconds) are the scans' times.
///    Poses are PCD's viewpoints, or a poses file.
///  - a folder of the KITTI odometry benchmark: `velodyne/*.bin`, `calib.txt`
///    (row `Tr`), `poses.txt` or `poses/NN.txt` here or two levels up (NN: the
///    folder's name), `times.txt` if there is one. The robot frame is the
///    Velodyne; the map frame is the first camera frame turned so that x is
///    forward, y left and z up.
///  - a drive of KITTI's raw data: `velodyne_points`, `oxts`, and `calib_imu_to_velo.txt`
///    in it or one level up. The robot frame is that of the inertial unit, the map frame
///    its first one.
///  - a folder of `.bin` scans as KITTI's, named by time (MulRan), with a poses file.
///  - a folder of the TUM RGB-D benchmark, or ICL-NUIM: `depth/*.png`, `associations.txt`
///    or `depth.txt`, `groundtruth.txt` or `*.gt.freiburg`. The robot frame is the optical
///    frame of the camera.
///
/// Extensions may be in capitals. In folders with a scan a file, a poses file may have the
/// 12 columns of KITTI, one row a scan.
///
/// \throws InputError: unreadable, truncated, no scans, no poses, no scan that
///         has a pose
std::unique_ptr<ScanSource> openScanSource(const std::string& path,
                                           const ScanSourceOptions& options = {});

/// Refuses labels of sensors that no source has, where others that are asked for are found.
/// \param asked comma-separated
/// \param labels of all sources, see ScanSource::sensorLabels()
/// \throws InputError naming the label and those that there are
void checkSensorLabels(const std::string& asked, const std::vector<std::string>& labels);

}  // namespace superray
