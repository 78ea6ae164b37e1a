// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/external_file.h"

#include <mrpt/io/lazy_load_path.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/stl_serialization.h>
#include <superray/maps/compressed_input.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/newer_objects.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace superray {
namespace {

using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;

/// Calls `read(file)`; says which file is broken, and how.
template <class Reader>
void readFile(const std::string& path, const Reader& read) {
    CompressedInput file(path);
    std::string why;
    try {
        read(file);
        // The check sum is at the end.
        while (!file.atEnd()) {
            char rest[4096];
            file.Read(rest, sizeof rest);
        }
        why = file.error();
    } catch (const std::exception& e) {
        why = file.error().empty() ? e.what() : file.error();
    }
    if (!why.empty())
        throw std::runtime_error(path + ": external file of a scan cannot be read: " + why +
                                 ", at byte " + std::to_string(file.fileOffset()) + " of " +
                                 std::to_string(file.fileSize()));
}

/// The storage format of a cloud, which MRPT tells to derived classes only.
struct StorageFormat : CObservationPointCloud {
    static ExternalStorageFormat of(const CObservationPointCloud& cloud) {
        return cloud.*&StorageFormat::m_externally_stored;
    }
};

bool loadCloud(const CObservationPointCloud& scan) {
    if (scan.pointcloud) return true;
    using Format = CObservationPointCloud::ExternalStorageFormat;
    if (StorageFormat::of(scan) != Format::MRPT_Serialization) return false;
    const auto path = mrpt::io::lazy_load_absolute_path(scan.getExternalStorageFile());
    readFile(path, [&](CompressedInput& file) {
        auto cloud = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(readObject(file));
        if (!cloud) throw std::runtime_error("it holds no point cloud");
        // load() is const in MRPT, too: the data are a cache of the file.
        const_cast<CObservationPointCloud&>(scan).pointcloud = std::move(cloud);
    });
    return true;
}

bool isZstd(const std::string& path) {
    return std::filesystem::is_regular_file(path) &&
           CompressedInput(path).compression() == Compression::zstd;
}

/// The layout of MRPT's `*_RANGES.bin`: rows, columns, values row by row.
void loadRangeImage(CObservation3DRangeScan& scan, const std::string& path) {
    readFile(path, [&](CompressedInput& file) {
        auto archive = mrpt::serialization::archiveFrom(file);
        std::uint32_t rows = 0, columns = 0;
        archive >> rows >> columns;
        if (rows > 65536 || columns > 65536)
            throw std::runtime_error("a range image of " + std::to_string(columns) + " x " +
                                     std::to_string(rows) + " pixels: at most 65536 a side");
        // Grows as the file does: a damaged size must not ask for gigabytes.
        std::vector<std::uint16_t> values;
        for (std::size_t i = 0; i < std::size_t{rows} * columns; ++i)
            values.push_back(archive.ReadAs<std::uint16_t>());
        mrpt::math::CMatrix_u16 image(rows, columns);
        std::copy(values.begin(), values.end(), image.data());
        scan.rangeImage = std::move(image);
    });
}

/// The layout of MRPT's `*_3D.bin`: all x, all y, all z.
void loadPoints(CObservation3DRangeScan& scan, const std::string& path) {
    readFile(path, [&](CompressedInput& file) {
        auto archive = mrpt::serialization::archiveFrom(file);
        std::vector<float> x, y, z;
        archive >> x >> y >> z;
        scan.points3D_x = {x.begin(), x.end()};
        scan.points3D_y = {y.begin(), y.end()};
        scan.points3D_z = {z.begin(), z.end()};
    });
}

/// Only what an MRPT that does not know zstd cannot read itself.
bool loadRangeScan(const CObservation3DRangeScan& scan) {
    if (kMrptReadsZstd) return false;
    const bool image = scan.hasRangeImage && scan.rangeImage_isExternallyStored();
    const bool points = scan.hasPoints3D && scan.points3D_isExternallyStored();
    const auto imagePath =
        image ? scan.rangeImage_getExternalStorageFileAbsolutePath("") : std::string();
    const auto pointsPath =
        points ? scan.points3D_getExternalStorageFileAbsolutePath() : std::string();
    const bool imageIsZstd = image && isZstd(imagePath);
    const bool pointsAreZstd = points && isZstd(pointsPath);
    if (!imageIsZstd && !pointsAreZstd) return false;
    auto& loaded = const_cast<CObservation3DRangeScan&>(scan);
    if (image) loadRangeImage(loaded, imagePath);
    if (points) loadPoints(loaded, pointsPath);
    return true;
}

}  // namespace

void loadExternalData(const mrpt::obs::CObservation& observation) {
    if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation)) {
        if (loadCloud(*cloud)) return;
    } else if (const auto* scan = dynamic_cast<const CObservation3DRangeScan*>(&observation)) {
        if (loadRangeScan(*scan)) return;
    }
    observation.load();
}

}  // namespace superray
