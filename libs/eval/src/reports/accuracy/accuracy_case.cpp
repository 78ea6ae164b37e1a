// SPDX-License-Identifier: BSD-3-Clause
#include "reports/accuracy/accuracy_case.h"

#include <superray/eval/incidence.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace superray {
namespace {

/// The incidence of one in so many occupied test points is looked at: casting rays is slow.
constexpr std::size_t kIncidenceStride = 16;
constexpr double kBelowSensor = 0.5;  // m: where a picture's layer lies

std::uint64_t numberOf(const Cell<3>& cell) {
    std::uint64_t number = 0;
    for (const std::int32_t i : cell)
        number = number << 16 | static_cast<std::uint16_t>(i + kCellLimit);
    return number;
}

Cell<3> cellOfNumber(std::uint64_t number) {
    Cell<3> cell;
    for (int a = 0; a < 3; ++a)
        cell[static_cast<std::size_t>(a)] =
            static_cast<std::int32_t>(number >> (16 * (2 - a)) & 0xFFFF) - kCellLimit;
    return cell;
}

void lookAtTests(AccuracyCase& c, const std::vector<PointScan>& scans) {
    const CellGeometry<3> geometry(c.resolution);
    auto& tests = c.split.tests;
    // Points beyond the addressable cells are in no map.
    tests.erase(std::remove_if(tests.begin(), tests.end(),
                               [&](const TestPoint& t) {
                                   return !geometry.contains(t.point.cast<double>());
                               }),
                tests.end());
    std::size_t occupied = 0;
    for (const TestPoint& t : tests) {
        const Eigen::Vector3f& origin = scans[t.scan].origin;
        c.originOfTest.push_back(origin);
        c.cellOfTest.push_back(numberOf(geometry.cellOf(t.point.cast<double>())));
        if (c.world == nullptr) continue;
        float incidence = std::numeric_limits<float>::quiet_NaN();
        if (t.occupied && occupied++ % kIncidenceStride == 0)
            if (const auto angle = incidenceOf(*c.world, origin.cast<double>(),
                                               (t.point - origin).cast<double>(), t.scan))
                incidence = static_cast<float>(*angle);
        c.incidenceOfTest.push_back(incidence);
    }
}

/// Takes the test points out of the exact scans.
void removeTests(std::vector<PointScan>& exact, const std::vector<TestPoint>& tests) {
    if (exact.empty()) return;  // a recording
    std::vector<std::vector<bool>> tested(exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) tested[i].resize(exact[i].points.size());
    for (const TestPoint& t : tests) tested[t.scan][t.ray] = true;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        std::size_t kept = 0;
        for (std::size_t n = 0; n < exact[i].points.size(); ++n)
            if (!tested[i][n]) exact[i].points[kept++] = exact[i].points[n];
        exact[i].points.resize(kept);
    }
}

}  // namespace

AccuracyCase makeCase(const AccuracyRequest& request, const PointScans& scans,
                      const PointScans* exact, const SimulatedWorld* world, double resolution) {
    AccuracyCase c{request, world, resolution, {}, {}, {}, {}, {}, {}, {}, {}, {}};
    if (exact != nullptr) c.exact = exact->scans;
    if (world != nullptr && world->moves()) {
        c.inserted = scans.scans;
    } else {
        c.split = splitScans(scans.scans, {resolution, TrainingPoints::share, request.testShare,
                                           request.testSeed});
        c.inserted = std::move(c.split.training);
        removeTests(c.exact, c.split.tests);
        lookAtTests(c, scans.scans);
    }
    addPoseNoise(c.inserted, request.poseNoise, request.testSeed);
    for (const PointScan& scan : c.inserted) {
        c.bounds.extend(scan.origin);
        for (const Eigen::Vector3f& p : scan.points) c.bounds.extend(p);
    }
    if (world != nullptr && !world->moves())
        c.truth.emplace(*world, resolution, c.inserted, c.exact);
    const double height =
        CellGeometry<3>(resolution)
            .lowerCorner(CellGeometry<3>(resolution)
                             .cellOf({0, 0, scans.scans.front().origin.z() - kBelowSensor}))
            .z();
    c.slice = request.slice.value_or(Slice{height, height + resolution});
    return c;
}

std::vector<TrueCell> cellsOfSlice(const AccuracyCase& c) {
    const CellGeometry<3> geometry(c.resolution);
    std::vector<TrueCell> cells;
    const auto add = [&](const TrueCell& cell) {
        const double z = geometry.center(cell.cell).z();
        if (z >= c.slice.low && z <= c.slice.high) cells.push_back(cell);
    };
    if (c.truth) {
        c.truth->forEachCell(add);
        return cells;
    }
    std::unordered_map<std::uint64_t, int> balance;
    for (std::size_t i = 0; i < c.cellOfTest.size(); ++i)
        balance[c.cellOfTest[i]] += c.split.tests[i].occupied ? 1 : -1;
    for (const auto& [number, more] : balance)
        add({cellOfNumber(number), more >= 0, more >= 0 ? 1u : 0u});
    return cells;
}

}  // namespace superray
