// SPDX-License-Identifier: BSD-3-Clause
// MRPT streams of points maps.

#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "mrpt/points_map_occupancy.h"

namespace superray {
namespace {

/// Points of a stream: little-endian cell, ends, x, y, z, one after the other.
template <int Dim>
struct PointBytesOf {
    static constexpr std::size_t kSize = 4 * (Dim + 1 + 3);  // of a point
    std::vector<std::uint8_t> bytes;
    std::size_t at = 0;

    template <class Number>
    void put(Number value) {
        static_assert(sizeof value == 4);
        std::uint32_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        for (int shift = 0; shift < 32; shift += 8)
            bytes.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
    template <class Number>
    void get(Number& value) {
        static_assert(sizeof value == 4);
        std::uint32_t bits = 0;
        for (int shift = 0; shift < 32; shift += 8) bits |= std::uint32_t{bytes[at++]} << shift;
        std::memcpy(&value, &bits, sizeof bits);
    }
    std::uint32_t checksum() const {
        return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
    }
};

/// The mean of end points in a cell lies in the cell, but for its rounding.
template <int Dim>
bool liesInCell(const CellGeometry<Dim>& geometry, const Cell<Dim>& cell,
                const std::array<float, 3>& position) {
    const Point<Dim> center = geometry.center(cell);
    for (std::size_t a = 0; a < position.size(); ++a) {
        const double middle = a < Dim ? center[static_cast<Eigen::Index>(a)] : 0.0;
        const double edge = a < Dim ? geometry.resolution() : 0.0;
        const double rounding = 1e-6 * (std::abs(middle) + edge);
        if (!(std::abs(double{position[a]} - middle) <= edge / 2 + rounding)) return false;
    }
    return true;
}

/// What can be done about points that others changed.
constexpr const char* kWayOut =
    "; write occupancy(), or the points as a CSimplePointsMap, instead";

/// Points that others moved would be refused when the stream is read.
template <int Dim>
[[noreturn]] void failMoved(std::size_t point, const std::array<float, 3>& position) {
    std::ostringstream message;
    message << "CSuperRayPointsMap" << Dim << "D: point " << point << " at (" << position[0]
            << ", " << position[1] << ", " << position[2]
            << ") must lie in its cell, but others moved it (setPoint(), "
               "changeCoordinatesReference()), and cells do not follow"
            << kWayOut;
    throw std::logic_error(message.str());
}

}  // namespace

template <int Dim>
void CSuperRayPointsMap<Dim>::writeTo(mrpt::serialization::CArchive& out) const {
    using PointBytes = PointBytesOf<Dim>;
    if (size() != sources_.size())
        throw std::logic_error("CSuperRayPointsMap" + std::to_string(Dim) +
                               "D: " + std::to_string(size()) + " points for " +
                               std::to_string(sources_.size()) +
                               " occupied cells: must be as many, but others added or "
                               "removed points" +
                               kWayOut);
    const auto& geometry = occupancy_->storage().geometry();
    PointBytes points;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const std::array<float, 3> position{m_x[i], m_y[i], m_z[i]};
        if (!liesInCell<Dim>(geometry, sources_[i].cell, position)) failMoved<Dim>(i, position);
        for (const auto c : sources_[i].cell) points.put(c);
        points.put(sources_[i].ends);
        for (const float coordinate : position) points.put(coordinate);
    }
    out << static_cast<const GridMap&>(*occupancy_);
    out << static_cast<std::uint64_t>(sources_.size());
    if (!points.bytes.empty()) out.WriteBuffer(points.bytes.data(), points.bytes.size());
    out << points.checksum();
}

template <int Dim>
void CSuperRayPointsMap<Dim>::readFrom(mrpt::serialization::CArchive& in,
                                       std::uint8_t version) {
    using PointBytes = PointBytesOf<Dim>;
    if (version > kSerialVersion)
        throw std::runtime_error("CSuperRayPointsMap: version " + std::to_string(version) +
                                 " in the stream is newer than this library's, " +
                                 std::to_string(kSerialVersion));
    CSuperRayPointsMap read(1.0);
    GridMap grid;
    // Within the bound of this map.
    TMapOptions bounded = grid.options();
    bounded.creation.max_memory_megabytes = occupancy_->options().creation.max_memory_megabytes;
    grid.setOptions(bounded);
    in >> grid;
    read.occupancy_->takeFrom(grid);
    read.genericMapParams = grid.genericMapParams;
    read.followAllBlocks();
    read.occupancy_->requireBound();
    std::uint64_t count = 0;
    in >> count;
    if (count != read.sources_.size())
        throw std::runtime_error("CSuperRayPointsMap: the stream has " + std::to_string(count) +
                                 " points for " + std::to_string(read.sources_.size()) +
                                 " occupied cells");
    // Same cells in the order of the stream, for equal maps to stay equal.
    read.forgetPoints();
    PointBytes points;
    points.bytes.resize(count * PointBytes::kSize);
    if (!points.bytes.empty() &&
        in.ReadBuffer(points.bytes.data(), points.bytes.size()) != points.bytes.size())
        throw std::runtime_error("CSuperRayPointsMap: unexpected end of stream");
    if (version > 0 && in.ReadAs<std::uint32_t>() != points.checksum())
        throw std::runtime_error("CSuperRayPointsMap: checksum of the points is wrong");
    for (std::uint64_t i = 0; i < count; ++i) {
        Source source{};
        std::array<float, 3> position{};
        for (auto& c : source.cell) points.get(c);
        points.get(source.ends);
        for (float& coordinate : position) points.get(coordinate);
        read.readPoint(source, position);
    }
    read.mark_as_modified();
    copyAll(read);
}

/// Adds a point from a stream. \throws std::runtime_error
template <int Dim>
void CSuperRayPointsMap<Dim>::readPoint(const Source& source,
                                        const std::array<float, 3>& position) {
    requireInCell(source, position);
    const auto value = occupancy_->storage().logOdds(source.cell);
    if (!value || *value < occupancy_->sensorModel().occupied() ||
        pointAt(source.cell) != kNoPoint)
        throw std::runtime_error(
            "CSuperRayPointsMap: a point in the stream has no occupied cell of its own");
    addPoint(source, position);
}

template <int Dim>
void CSuperRayPointsMap<Dim>::requireInCell(const Source& source,
                                            const std::array<float, 3>& position) const {
    for (const auto c : source.cell)
        if (c < -kCellLimit || c >= kCellLimit)
            throw std::runtime_error("CSuperRayPointsMap: a point in the stream has cell " +
                                     std::to_string(c));
    if (!liesInCell<Dim>(occupancy_->storage().geometry(), source.cell, position))
        throw std::runtime_error(
            "CSuperRayPointsMap: a point in the stream lies outside its cell");
}

template void CSuperRayPointsMap<2>::writeTo(mrpt::serialization::CArchive&) const;
template void CSuperRayPointsMap<3>::writeTo(mrpt::serialization::CArchive&) const;
template void CSuperRayPointsMap<2>::readFrom(mrpt::serialization::CArchive&, std::uint8_t);
template void CSuperRayPointsMap<3>::readFrom(mrpt::serialization::CArchive&, std::uint8_t);
template void CSuperRayPointsMap<2>::readPoint(const Source&, const std::array<float, 3>&);
template void CSuperRayPointsMap<3>::readPoint(const Source&, const std::array<float, 3>&);
template void CSuperRayPointsMap<2>::requireInCell(const Source&,
                                                   const std::array<float, 3>&) const;
template void CSuperRayPointsMap<3>::requireInCell(const Source&,
                                                   const std::array<float, 3>&) const;

}  // namespace superray
