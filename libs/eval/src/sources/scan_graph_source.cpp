// SPDX-License-Identifier: BSD-3-Clause
// OctoMap's ScanGraph file, little endian: u32 number of nodes; per node a point
// cloud, a pose and a u32 id; then edges, which a mapper does not need.
//   point cloud: u32 count, count vectors      (in the frame of the pose)
//   pose:        vector, then i32 4 and four f64 quaternion terms u x y z
//   vector:      i32 3 and three f64
//   edges:       u32 count, count edges: ids of two nodes (u32), pose, weight (f64)
// Read here rather than by OctoMap, which believes every count it reads.

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/math/CQuaternion.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "sources/clouds/sensor_points.h"
#include "sources/scan_source_formats.h"

namespace superray {
namespace {

constexpr std::uint64_t kVectorBytes = 4 + 3 * 8;
constexpr std::uint64_t kEdgeBytes = 4 + 4 + kVectorBytes + (4 + 4 * 8) + 8;

class GraphReader {
 public:
    explicit GraphReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {
        std::error_code error;
        size_ = std::filesystem::file_size(path, error);
        if (!file_ || error) throw InputError(path + ": cannot be opened for reading");
        refusePoseGraph();
        nodes_ = read<std::uint32_t>();
    }

    std::uint32_t nodes() const { return nodes_; }

    /// The points of the next node, in its own frame.
    mrpt::maps::CSimplePointsMap::Ptr readPoints() {
        const auto count = checkedPointCount();
        auto points = mrpt::maps::CSimplePointsMap::Create();
        points->reserve(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const auto p = readNumbers<3>();
            addPoint(*points, p);
        }
        points->mark_as_modified();
        return points;
    }

    void skipPoints() {
        file_.seekg(static_cast<std::streamoff>(checkedPointCount() * kVectorBytes),
                    std::ios::cur);
    }

    /// The pose and id that follow the points.
    mrpt::poses::CPose3D readPose() {
        const auto t = readNumbers<3>();
        const auto q = readNumbers<4>();
        read<std::uint32_t>();
        const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
        if (!(std::abs(norm - 1) < 0.01)) fail("a node's rotation is not a unit quaternion");
        const mrpt::math::CQuaternionDouble rotation(q[0] / norm, q[1] / norm, q[2] / norm,
                                                     q[3] / norm);
        if (!std::isfinite(t[0] + t[1] + t[2])) fail("a node's position is not finite");
        return mrpt::poses::CPose3D(rotation, t[0], t[1], t[2]);
    }

    /// After the last node. Reads no edge, but they must be all that is left.
    void checkEdges() {
        const std::uint64_t at = static_cast<std::uint64_t>(file_.tellg());
        if (at == size_) return;
        const std::uint64_t edges = read<std::uint32_t>();
        const std::uint64_t left = size_ - at - sizeof(std::uint32_t);
        if (left != edges * kEdgeBytes)
            fail(std::to_string(left) + " bytes are left after its " + std::to_string(nodes_) +
                 " nodes and the number of edges, " + std::to_string(edges) + ", which have " +
                 std::to_string(edges * kEdgeBytes));
    }

    [[noreturn]] void fail(const std::string& why) {
        file_.clear();
        throw InputError(path_ + ": is not a whole OctoMap scan graph: " + why + " (at byte " +
                         std::to_string(file_.tellg()) + " of " + std::to_string(size_) + ")");
    }

 private:
    /// MRPT and g2o name their text files so, too.
    void refusePoseGraph() {
        std::string start(6, '\0');
        file_.read(start.data(), static_cast<std::streamsize>(start.size()));
        if (start == "VERTEX" || start.rfind("EDGE", 0) == 0)
            throw InputError(
                path_ +
                ": is a graph of poses (text), and holds no scans; an OctoMap scan "
                "graph is wanted");
        file_.clear();
        file_.seekg(0);
    }

    void addPoint(mrpt::maps::CSimplePointsMap& points, const std::array<double, 3>& p) const {
        try {
            addSensorPoint(points, p[0], p[1], p[2]);
        } catch (const FarCoordinate& e) {
            throw InputError(path_ + ": " + e.what());
        }
    }

    template <class T>
    T read() {
        T value{};
        if (!file_.read(reinterpret_cast<char*>(&value), sizeof value)) fail("it ends early");
        return value;
    }

    template <std::size_t N>
    std::array<double, N> readNumbers() {
        if (read<std::int32_t>() != static_cast<std::int32_t>(N))
            fail("a vector does not have " + std::to_string(N) + " elements");
        std::array<double, N> v;
        for (double& x : v) x = read<double>();
        return v;
    }

    std::uint32_t checkedPointCount() {
        const auto count = read<std::uint32_t>();
        const auto at = static_cast<std::uint64_t>(file_.tellg());
        if (count * kVectorBytes > size_ - at)
            fail("a node claims " + std::to_string(count) +
                 " points, more than the file has room for");
        return count;
    }

    std::string path_;
    std::ifstream file_;
    std::uint64_t size_ = 0;
    std::uint32_t nodes_ = 0;
};

class ScanGraphSource final : public ScanSource {
    static constexpr const char* kLabel = "GRAPH";

 public:
    ScanGraphSource(const std::string& path, const ScanSourceOptions& options)
        : lookup_(options), reader_(path) {
        if (options.poses == PoseOrigin::file)
            throw InputError(path +
                             ": a scan graph has no times, so a poses file cannot apply");
        if (!acceptsLabel(options, kLabel))
            throw InputError(path + ": the scans have the sensor label '" + kLabel +
                             "', but '" + options.sensorLabel + "' is asked for");
        GraphReader check(path);
        std::uint32_t whole = 0;
        try {
            for (; whole < check.nodes(); ++whole) {
                check.skipPoints();
                check.readPose();
            }
            check.checkEdges();
        } catch (const InputError& e) {
            warning_ = std::string(e.what()) + "; scans before it: " + std::to_string(whole);
            if (options.truncation == Truncation::error || whole == 0)
                throw InputError(warning_);
        }
        if (whole == 0) throwNoScans(path, options, {});
        total_ = std::min<std::uint64_t>(whole, options.maxScans);
    }

    std::vector<std::string> sensorLabels() const override { return {kLabel}; }
    std::uint64_t total() const override { return total_; }
    SkippedObservations skipped() const override { return {}; }
    std::string warning() const override { return warning_; }
    PoseSummary poses() const override {
        return lookup_.summary({}, PoseSummary("nodes of the graph", reader_.nodes()));
    }

    std::optional<Scan> next() override {
        if (delivered_ == total_) return std::nullopt;
        ++delivered_;
        auto observation = mrpt::obs::CObservationPointCloud::Create();
        observation->sensorLabel = kLabel;
        observation->timestamp = mrpt::Clock::time_point();
        observation->pointcloud = reader_.readPoints();
        const auto pose = lookup_.pose(observation->timestamp, reader_.readPose());
        return Scan{observation->timestamp, *pose.pose, observation};
    }

 private:
    PoseLookup lookup_;
    GraphReader reader_;
    std::string warning_;
    std::uint64_t total_ = 0, delivered_ = 0;
};

}  // namespace

std::unique_ptr<ScanSource> openScanGraph(const std::string& path,
                                          const ScanSourceOptions& options) {
    return std::make_unique<ScanGraphSource>(path, options);
}

}  // namespace superray
