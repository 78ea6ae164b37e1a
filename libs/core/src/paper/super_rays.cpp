// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/block.h>
#include <superray/core/ray_line.h>
#include <superray/core/super_rays.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace superray {
namespace {

constexpr std::uint32_t kEmpty = 0xFFFFFFFFu;
/// Segment number of a ray that is too close to a border.
constexpr std::uint64_t kUncertain = ~std::uint64_t{0};
/// Room for one segment number in Keyed::segments (three fit).
constexpr int kSegmentBits = 21;

}  // namespace

template <int Dim>
const std::vector<SuperRay>& SuperRayGrouper<Dim>::group(const RayBundle<Dim>& rays,
                                                         std::uint32_t threshold) {
    out_.clear();
    const auto alone = [&](std::uint32_t ray) { out_.push_back({ray, 1}); };
    if (!rays.hasCommonOrigin()) {
        for (std::uint32_t i = 0; i < rays.size(); ++i) alone(i);
        return out_;
    }
    bucketByEndCell(rays);
    for (std::size_t b = 0; b + 1 < bucketStart_.size(); ++b) {
        const std::uint32_t* begin = sorted_.data() + bucketStart_[b];
        const std::uint32_t* end = sorted_.data() + bucketStart_[b + 1];
        if (end - begin < static_cast<std::ptrdiff_t>(threshold))
            std::for_each(begin, end, alone);
        else
            groupEndCell(rays, begin, end);
    }
    return out_;
}

/// Counting sort of the rays by (end cell, kind), in order of first appearance.
template <int Dim>
void SuperRayGrouper<Dim>::bucketByEndCell(const RayBundle<Dim>& rays) {
    const std::size_t n = rays.size();
    std::size_t capacity = 64;
    while (capacity < 2 * n) capacity *= 2;
    table_.assign(capacity, kEmpty);
    bucketOf_.resize(n);
    endCells_.clear();
    std::vector<RayEnd> kinds;
    bucketStart_.assign(1, 0);

    std::uint32_t previous = kEmpty;  // consecutive points often share a cell
    for (std::size_t i = 0; i < n; ++i) {
        const Cell<Dim> cell = rays.geometry().cellOf(rays.end(i));
        const RayEnd kind = rays.kind(i);
        const auto matches = [&](std::uint32_t b) {
            return endCells_[b] == cell && kinds[b] == kind;
        };
        if (previous == kEmpty || !matches(previous)) {
            std::size_t slot = IndexHash{}(cell) & (capacity - 1);
            while (table_[slot] != kEmpty && !matches(table_[slot]))
                slot = (slot + 1) & (capacity - 1);
            if (table_[slot] == kEmpty) {
                table_[slot] = static_cast<std::uint32_t>(endCells_.size());
                endCells_.push_back(cell);
                kinds.push_back(kind);
                bucketStart_.push_back(0);
            }
            previous = table_[slot];
        }
        bucketOf_[i] = previous;
        ++bucketStart_[previous + 1];
    }
    for (std::size_t b = 1; b < bucketStart_.size(); ++b)
        bucketStart_[b] += bucketStart_[b - 1];
    sorted_.resize(n);
    std::vector<std::uint32_t> next(bucketStart_.begin(), bucketStart_.end() - 1);
    for (std::size_t i = 0; i < n; ++i)
        sorted_[next[bucketOf_[i]]++] = static_cast<std::uint32_t>(i);
}

template <int Dim>
void SuperRayGrouper<Dim>::groupEndCell(const RayBundle<Dim>& rays, const std::uint32_t* begin,
                                        const std::uint32_t* end) {
    keyed_.clear();
    for (const std::uint32_t* r = begin; r != end; ++r) keyed_.push_back({0, *r});
    const Cell<Dim> endCell = rays.geometry().cellOf(rays.end(*begin));
    for (int a = 0; a < Dim; ++a)
        for (int b = a + 1; b < Dim; ++b) divideByMappingLine(rays, endCell, a, b);

    std::sort(keyed_.begin(), keyed_.end(), [](const Keyed& x, const Keyed& y) {
        return x.segments != y.segments ? x.segments < y.segments : x.ray < y.ray;
    });
    for (std::size_t i = 0; i < keyed_.size();) {
        std::size_t j = i + 1;
        if (keyed_[i].segments != kUncertain)
            while (j < keyed_.size() && keyed_[j].segments == keyed_[i].segments) ++j;
        out_.push_back({keyed_[i].ray, static_cast<std::uint32_t>(j - i)});
        i = j;
    }
}

/// The plane of two axes, mirrored so that all rays to one end cell go up both of them.
/// Coordinates are in cells from the grid's origin, so that cells are whole numbers.
template <int Dim>
struct SuperRayGrouper<Dim>::MappingLine {
    CellGeometry<Dim> geometry;
    int axisA, axisB;         ///< the rays cross more borders of axis A
    double signA, signB;      ///< -1 where mirrored
    int crossedA, crossedB;   ///< borders of each axis that every ray crosses
    double originA, originB;  ///< of the rays
    /// Distance [cells] within which a ray passes a grid point uncertainly, along either
    /// axis: the digital line lags by at most (slices + 2) 2^-31, and doubles of at most
    /// 2^16 add far less.
    double margin;

    MappingLine(const RayBundle<Dim>& rays, const Cell<Dim>& endCell, int a, int b)
        : geometry(rays.geometry()), axisA(a), axisB(b) {
        const Cell<Dim> sensorCell = geometry.cellOf(rays.commonOrigin());
        const auto crossed = [&](int axis) {
            return std::abs(endCell[axis] - sensorCell[axis]);
        };
        if (crossed(axisA) < crossed(axisB)) std::swap(axisA, axisB);
        signA = endCell[axisA] < sensorCell[axisA] ? -1 : 1;
        signB = endCell[axisB] < sensorCell[axisB] ? -1 : 1;
        crossedA = crossed(axisA);
        crossedB = crossed(axisB);
        originA = mirrored(rays.commonOrigin(), axisA, signA);
        originB = mirrored(rays.commonOrigin(), axisB, signB);
        int slices = 0;
        for (int axis = 0; axis < Dim; ++axis) slices = std::max(slices, crossed(axis));
        margin = (slices + 16) * 0x1p-28;
    }

    /// Slope of the ray to `end`: its coordinate on the mapping line.
    double slope(const Point<Dim>& end) const {
        return (mirrored(end, axisB, signB) - originB) /
               (mirrored(end, axisA, signA) - originA);
    }

 private:
    /// Quantised as the digital line is: never on a border.
    double mirrored(const Point<Dim>& p, int axis, double sign) const {
        return sign * static_cast<double>(toUnits(geometry.scaled(p[axis]))) * 0x1p-31;
    }
};

/// Appends to every ray of keyed_ its segment on the mapping line of the plane
/// (axisA, axisB).
template <int Dim>
void SuperRayGrouper<Dim>::divideByMappingLine(const RayBundle<Dim>& rays,
                                               const Cell<Dim>& endCell, int axisA, int axisB) {
    const MappingLine line(rays, endCell, axisA, axisB);
    // Borders of one axis only: their order is the same for all rays.
    if (line.crossedA == 0 || line.crossedB == 0) return;
    findSlopes(rays, line);
    findBorders(line);
    if (borders_.size() >= (std::size_t{1} << kSegmentBits) - 1) {
        for (Keyed& k : keyed_) k.segments = kUncertain;
        return;
    }
    mergeOverlappingBorders();
    appendSegments();
}

/// Fills slopes_, parallel to keyed_.
template <int Dim>
void SuperRayGrouper<Dim>::findSlopes(const RayBundle<Dim>& rays, const MappingLine& line) {
    slopes_.clear();
    for (const Keyed& k : keyed_) slopes_.push_back(line.slope(rays.end(k.ray)));
}

/// Fills borders_ with the stretch of the mapping line that each grid point makes uncertain.
///
/// The ray of slope s passes the grid point at distance d along axis A and height h along
/// axis B uncertainly if it is off by |s d - h| <= margin (1 + s): a lag along A matters s
/// times as much as one along B. Solved for h, these are the grid points that some ray may
/// pass so; solved for s, the stretch of one of them.
template <int Dim>
void SuperRayGrouper<Dim>::findBorders(const MappingLine& line) {
    const auto firstBorder = [](double origin) { return std::floor(origin) + 1; };
    const auto [lowest, highest] = std::minmax_element(slopes_.begin(), slopes_.end());
    const double margin = line.margin;
    const double firstB = firstBorder(line.originB), lastB = firstB + line.crossedB - 1;
    const double firstA = firstBorder(line.originA);
    borders_.clear();
    for (int i = 0; i < line.crossedA; ++i) {
        const double distance = firstA + i - line.originA;  // > 0
        const auto from = static_cast<std::int64_t>(
            std::max(firstB, std::ceil(line.originB + *lowest * (distance - margin) - margin)));
        const auto to = static_cast<std::int64_t>(std::min(
            lastB, std::floor(line.originB + *highest * (distance + margin) + margin)));
        for (std::int64_t j = from; j <= to; ++j) {
            const double height = static_cast<double>(j) - line.originB;  // > 0
            borders_.push_back(
                {(height - margin) / (distance + margin),
                 distance > margin ? (height + margin) / (distance - margin) : HUGE_VAL});
        }
    }
}

/// Sorts borders_ and makes one of those that overlap.
template <int Dim>
void SuperRayGrouper<Dim>::mergeOverlappingBorders() {
    std::sort(borders_.begin(), borders_.end(),
              [](const Border& x, const Border& y) { return x.from < y.from; });
    std::size_t merged = 0;
    for (const Border& b : borders_) {
        if (merged > 0 && b.from <= borders_[merged - 1].to)
            borders_[merged - 1].to = std::max(borders_[merged - 1].to, b.to);
        else
            borders_[merged++] = b;
    }
    borders_.resize(merged);
}

/// A segment is named by the number of borders below it; a ray in a border has none.
template <int Dim>
void SuperRayGrouper<Dim>::appendSegments() {
    for (std::size_t r = 0; r < keyed_.size(); ++r) {
        const double slope = slopes_[r];
        const auto above =
            std::upper_bound(borders_.begin(), borders_.end(), slope,
                             [](double s, const Border& b) { return s < b.from; });
        const bool uncertain = above != borders_.begin() && slope <= std::prev(above)->to;
        std::uint64_t& segments = keyed_[r].segments;
        if (uncertain || segments == kUncertain)
            segments = kUncertain;
        else
            segments =
                segments << kSegmentBits | static_cast<std::uint64_t>(above - borders_.begin());
    }
}

template class SuperRayGrouper<2>;
template class SuperRayGrouper<3>;

}  // namespace superray
