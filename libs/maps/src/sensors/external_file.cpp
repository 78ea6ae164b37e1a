// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/external_file.h"

#include <mrpt/io/lazy_load_path.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/maps/newer_objects.h>

#include <cstring>

#include "sensors/external_input.h"
#include "sensors/range_scan_file.h"
#include "sensors/text_matrix.h"

namespace superray {
namespace {

using mrpt::obs::CObservationPointCloud;

/// The classes of MRPT that begin with their number of points.
bool isPlainPointsMap(const std::string& name) {
    for (const char* plain : {"CSimplePointsMap", "CPointsMapXYZI", "CPointsMapXYZIRT",
                              "CColouredPointsMap", "CWeightedPointsMap"})
        if (name == plain || name == std::string("mrpt::maps::") + plain) return true;
    return false;
}

/// The storage format of a cloud, which MRPT tells to derived classes only.
struct StorageFormat : CObservationPointCloud {
    static ExternalStorageFormat of(const CObservationPointCloud& cloud) {
        return cloud.*&StorageFormat::m_externally_stored;
    }
};

/// The file holds a point cloud, and room for as many points as it claims: MRPT believes
/// the count. `size`: bytes of the file, decompressed.
void checkSerializedCloud(CompressedInput& file, std::uint64_t size) {
    std::string start(1, '\0');
    file.Read(start.data(), 1);
    const std::size_t length = static_cast<unsigned char>(start[0]) & 0x7fu;
    // Length and name of the class, its version, the count.
    start.resize(1 + length + 1 + sizeof(std::uint32_t));
    start.resize(1 + file.Read(start.data() + 1, start.size() - 1));
    if (start.size() < 1 + length + 1 + sizeof(std::uint32_t))
        throw std::runtime_error("it ends in its first " + std::to_string(start.size()) +
                                 " bytes");
    const std::string name = start.substr(1, length);
    const auto* type = mrpt::rtti::findRegisteredClass(name);
    if (type == nullptr || !type->derivedFrom(CLASS_ID(mrpt::maps::CPointsMap)))
        throw std::runtime_error("it holds no point cloud");
    std::uint32_t points = 0;
    std::memcpy(&points, start.data() + start.size() - sizeof points, sizeof points);
    if (isPlainPointsMap(name) && points > size / (3 * sizeof(float)))
        throw std::runtime_error("it claims " + std::to_string(points) +
                                 " points, more than the file has room for");
    file.unread(start);
}

void loadSerializedCloud(CObservationPointCloud& scan, const std::string& path) {
    // The check sum, too, is read before what it is of.
    std::uint64_t size = 0;
    readWholeExternalFile(path, [&](CompressedInput& file) { size = drain(file); });
    readWholeExternalFile(path, [&](CompressedInput& file) {
        checkSerializedCloud(file, size);
        auto cloud = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(readObject(file));
        if (!cloud) throw std::runtime_error("it holds no point cloud");
        scan.pointcloud = std::move(cloud);
    });
}

/// What is checked here, MRPT reads.
void checkCloudFile(CObservationPointCloud::ExternalStorageFormat format,
                    const std::string& path) {
    using Format = CObservationPointCloud::ExternalStorageFormat;
    readWholeExternalFile(path, [&](CompressedInput& file) {
        if (format == Format::PlainTextFile) {
            readTextMatrix(file);
            return;
        }
        constexpr std::uint64_t kPoint = 4 * sizeof(float);
        const std::uint64_t bytes = drain(file);
        if (format == Format::KittiBinFile && bytes % kPoint != 0)
            throw std::runtime_error(std::to_string(bytes) +
                                     " bytes are no whole number of points of 16 bytes");
    });
}

void loadCloud(CObservationPointCloud& scan) {
    if (scan.pointcloud || !scan.isExternallyStored()) return;
    const auto format = StorageFormat::of(scan);
    const auto path = mrpt::io::lazy_load_absolute_path(scan.getExternalStorageFile());
    if (format == CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization) {
        loadSerializedCloud(scan, path);
    } else {
        checkCloudFile(format, path);
        scan.load();
    }
}

}  // namespace

void loadExternalData(const mrpt::obs::CObservation& observation) {
    // load() is const in MRPT, too: the data are a cache of the file.
    auto& loaded = const_cast<mrpt::obs::CObservation&>(observation);
    if (auto* cloud = dynamic_cast<CObservationPointCloud*>(&loaded))
        loadCloud(*cloud);
    else if (auto* scan = dynamic_cast<mrpt::obs::CObservation3DRangeScan*>(&loaded))
        loadRangeScan(*scan);
    else
        observation.load();
}

}  // namespace superray
