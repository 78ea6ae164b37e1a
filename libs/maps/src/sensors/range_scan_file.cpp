// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/range_scan_file.h"

#include <mrpt/math/CMatrixF.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/option_text.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "sensors/external_input.h"
#include "sensors/text_matrix.h"

namespace superray {
namespace {

using mrpt::obs::CObservation3DRangeScan;

bool isText(const std::string& path) {
    return equalIgnoringCase(std::filesystem::path(path).extension().string(), ".txt");
}

/// Before the pixels are read: an image of another size is of no use.
void checkSize(const CObservation3DRangeScan& scan, std::uint64_t rows, std::uint64_t columns) {
    const auto& camera = scan.cameraParams;
    if ((rows == 0 && columns == 0) || (rows == camera.nrows && columns == camera.ncols))
        return;
    throw std::runtime_error(
        "range image of " + std::to_string(columns) + " x " + std::to_string(rows) +
        " pixels: must have the size of its camera parameters, " +
        std::to_string(camera.ncols) + " x " + std::to_string(camera.nrows));
}

std::uint16_t toPixel(double value) {
    if (std::isnan(value)) return 0;  // no return
    const double pixel = std::round(value);
    if (pixel < 0 || pixel > 65535)
        throw std::runtime_error("a range of " + std::to_string(value) +
                                 " units: must be from 0 to 65535");
    return static_cast<std::uint16_t>(pixel);
}

template <class Values, class ToPixel>
void setImage(CObservation3DRangeScan& scan, std::size_t rows, std::size_t columns,
              const Values& values, const ToPixel& toPixel) {
    mrpt::math::CMatrix_u16 image(static_cast<int>(rows), static_cast<int>(columns));
    for (std::size_t i = 0; i < rows * columns; ++i) image.data()[i] = toPixel(values[i]);
    scan.rangeImage = std::move(image);
}

/// The layout of MRPT's `*_RANGES.bin`: rows, columns, values row by row.
void readImage(CObservation3DRangeScan& scan, CompressedInput& file) {
    const std::size_t rows = readExternalCount(file), columns = readExternalCount(file);
    checkSize(scan, rows, columns);
    setImage(scan, rows, columns, readExternalNumbers<std::uint16_t>(file, rows * columns),
             [](std::uint16_t pixel) { return pixel; });
}

/// Before version 9 of the scan: an object of the class CMatrix or CMatrixF, in metres.
void readMatrixObject(CObservation3DRangeScan& scan, CompressedInput& file,
                      std::size_t nameLength) {
    std::string start(1 + nameLength + 1, '\0');
    file.Read(start.data(), start.size());
    std::uint32_t size[2] = {readExternalCount(file), readExternalCount(file)};
    auto& camera = scan.cameraParams;
    // As MRPT does: its old recordings of TUM's data have the sides of the camera exchanged.
    if (size[0] == 480 && size[1] == 640 && camera.ncols == 480 && camera.nrows == 640)
        std::swap(camera.ncols, camera.nrows);
    checkSize(scan, size[0], size[1]);
    file.unread(start +
                std::string(reinterpret_cast<const char*>(size), 2 * sizeof(std::uint32_t)));
    mrpt::math::CMatrixF metres;
    mrpt::serialization::archiveFrom(file) >> metres;
    setImage(scan, static_cast<std::size_t>(metres.rows()),
             static_cast<std::size_t>(metres.cols()), metres.data(),
             [&](float range) { return toPixel(range / scan.rangeUnits); });
}

/// Length of the class's name if the file begins with a matrix as an object, not with a
/// number of rows; else 0.
std::size_t nameOfMatrix(CompressedInput& file) {
    std::string start(1, '\0');
    if (file.Read(start.data(), 1) == 0) return 0;
    const std::size_t length = static_cast<unsigned char>(start[0]) & 0x7fu;
    start.resize(1 + length);
    start.resize(1 + file.Read(start.data() + 1, length));
    file.unread(start);
    for (const char* name : {"CMatrix", "CMatrixF", "mrpt::math::CMatrixF"})
        if (start.compare(1, std::string::npos, name) == 0) return length;
    return 0;
}

void loadImage(CObservation3DRangeScan& scan, const std::string& path) {
    readWholeExternalFile(path, [&](CompressedInput& file) {
        if (isText(path)) {
            const TextMatrix text = readTextMatrix(file);
            checkSize(scan, text.rows(), text.columns);
            setImage(scan, text.rows(), text.columns, text.values,
                     [](float pixel) { return toPixel(pixel); });
        } else if (const std::size_t length = nameOfMatrix(file)) {
            readMatrixObject(scan, file, length);
        } else {
            readImage(scan, file);
        }
    });
}

/// MRPT writes a row for each point, and reads a row for each coordinate.
void setPoints(CObservation3DRangeScan& scan, const TextMatrix& text) {
    const std::size_t rows = text.rows(), columns = text.columns;
    if ((columns == 3) == (rows == 3))
        throw std::runtime_error("a matrix of " + std::to_string(rows) + " x " +
                                 std::to_string(columns) +
                                 " numbers: must have 3 columns, or 3 rows (not both)");
    const std::size_t count = columns == 3 ? rows : columns;
    const std::size_t point = columns == 3 ? 3 : 1, axis = columns == 3 ? 1 : columns;
    scan.points3D_x.resize(count);
    scan.points3D_y.resize(count);
    scan.points3D_z.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        scan.points3D_x[i] = text.values[i * point];
        scan.points3D_y[i] = text.values[i * point + axis];
        scan.points3D_z[i] = text.values[i * point + 2 * axis];
    }
}

/// The layout of MRPT's `*_3D.bin`: number and x of all points, the same of y and z.
void loadPoints(CObservation3DRangeScan& scan, const std::string& path) {
    readWholeExternalFile(path, [&](CompressedInput& file) {
        if (isText(path)) {
            setPoints(scan, readTextMatrix(file));
            return;
        }
        const auto read = [&] {
            return readExternalNumbers<float>(file, readExternalCount(file));
        };
        const auto x = read(), y = read(), z = read();
        scan.points3D_x = {x.begin(), x.end()};
        scan.points3D_y = {y.begin(), y.end()};
        scan.points3D_z = {z.begin(), z.end()};
    });
}

}  // namespace

void loadRangeScan(CObservation3DRangeScan& scan) {
    if (scan.hasPoints3D && scan.points3D_isExternallyStored() && scan.points3D_x.empty())
        loadPoints(scan, scan.points3D_getExternalStorageFileAbsolutePath());
    if (scan.hasRangeImage && scan.rangeImage_isExternallyStored() &&
        scan.rangeImage.size() == 0)
        loadImage(scan, scan.rangeImage_getExternalStorageFileAbsolutePath(""));
}

}  // namespace superray
