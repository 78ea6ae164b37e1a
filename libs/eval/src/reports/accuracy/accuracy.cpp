// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/stopwatch.h>
#include <superray/eval/accuracy.h>
#include <superray/eval/input_error.h>

#include <cmath>
#include <limits>
#include <ostream>

#include "pictures/slice_picture.h"
#include "reports/accuracy/accuracy_case.h"
#include "reports/accuracy/accuracy_contenders.h"

namespace superray {
namespace {

constexpr double kRanges[] = {0, 5, 10, 20, 40, std::numeric_limits<double>::infinity()};
constexpr double kIncidences[] = {0, 30, 60, 75, 85, 88, 90};

void validateSlice(const Slice& slice) {
    if (!(slice.low < slice.high && std::isfinite(slice.low) && std::isfinite(slice.high)))
        throw InputError("the slice is from " + std::to_string(slice.low) + " to " +
                         std::to_string(slice.high) + " m; the first must be the smaller one");
}

void addToBands(std::vector<AccuracyBand>& bands, double value, bool occupied,
                std::optional<double> probability) {
    for (AccuracyBand& band : bands)
        if (value >= band.from && value < band.to)
            (occupied ? band.occupied : band.free).add(occupied, probability);
}

template <std::size_t N>
std::vector<AccuracyBand> emptyBands(const double (&edges)[N]) {
    std::vector<AccuracyBand> bands;
    for (std::size_t i = 0; i + 1 < N; ++i) bands.push_back({edges[i], edges[i + 1], {}, {}});
    return bands;
}

void scoreTests(const AccuracyCase& c, const BenchEngine& engine, AccuracyRow& row) {
    std::vector<ScoredPoint> points;
    points.reserve(c.split.tests.size());
    row.byRange = emptyBands(kRanges);
    if (c.world != nullptr) row.byIncidence = emptyBands(kIncidences);
    for (std::size_t i = 0; i < c.split.tests.size(); ++i) {
        const TestPoint& t = c.split.tests[i];
        const auto p = engine.occupancy(t.point);
        points.push_back({t.occupied, p, c.cellOfTest[i]});
        addToBands(row.byRange, (t.point - c.originOfTest[i]).norm(), t.occupied, p);
        if (c.world != nullptr)
            addToBands(row.byIncidence, c.incidenceOfTest[i], t.occupied, p);
    }
    row.score = scoreOf(points);
}

CellVerdict verdictOf(bool known, bool occupied, bool solid, bool seen) {
    if (occupied) return solid ? CellVerdict::kept : CellVerdict::wrong;
    if (seen) return CellVerdict::missing;
    return known ? CellVerdict::free : CellVerdict::unknown;
}

SlicePanel panelOf(const AccuracyCase& c, const std::vector<TrueCell>& cells,
                   const BenchEngine& engine, const AccuracyRow& row) {
    SlicePanel panel{row.engine + ", " + row.policy, {}};
    if (row.model != "-") panel.title += ", " + row.model;
    const CellGeometry<3> geometry(c.resolution);
    for (const TrueCell& cell : cells) {
        const auto p = engine.occupancy(geometry.center(cell.cell).cast<float>());
        panel.cells.push_back(
            {cell.cell[0], cell.cell[1],
             verdictOf(p.has_value(), p && *p >= kOccupiedFrom, cell.solid, cell.seen > 0)});
    }
    return panel;
}

void insertAll(const std::vector<PointScan>& scans, BenchEngine& engine, std::ostream& log,
               ProgressMeter::Style style) {
    ProgressMeter meter(log, style);
    const Stopwatch watch;
    BuildProgress progress;
    progress.totalScans = scans.size();
    for (const PointScan& scan : scans) {
        engine.prepare(scan);
        engine.insert();
        ++progress.scans;
        progress.rays += scan.points.size();
        progress.seconds = watch.seconds();
        meter.update(progress);
    }
}

std::vector<AccuracyRow> runRows(const AccuracyCase& c, std::ostream& log,
                                 ProgressMeter::Style style, std::vector<SlicePanel>& panels) {
    std::vector<AccuracyRow> rows;
    std::vector<TrueCell> slice;
    if (c.request.pictures) slice = cellsOfSlice(c);
    for (const Contender& contender : contendersOf(c.request, c.resolution, c.bounds)) {
        AccuracyRow row = contender.row;
        log << row.engine << ", " << row.policy << ", model " << row.model << std::endl;
        const auto engine = contender.info->make(contender.options);
        if (c.world != nullptr && c.world->moves()) {
            row.moving = scoreMoving(*c.world, c.resolution, c.inserted, c.exact, *engine);
        } else {
            insertAll(c.inserted, *engine, log, style);
            scoreTests(c, *engine, row);
            if (c.truth) row.truth = c.truth->score(*engine);
            if (c.request.pictures) panels.push_back(panelOf(c, slice, *engine, row));
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace

void AccuracyRequest::validate() const {
    if (data.empty()) throw InputError("no data given");
    if (resolutions.empty()) throw InputError("no resolution given");
    for (const double resolution : resolutions)
        SplitOptions{resolution, TrainingPoints::share, testShare, testSeed}.validate();
    if (engines.empty()) throw InputError("no engines given");
    for (const std::string& name : engines) benchEngine(name);
    if (policies.empty()) throw InputError("no policy given");
    if (peerModels.empty()) throw InputError("no model of peers given");
    for (const double scanMissMin : scanMissMins) {
        SensorProbabilities p = SensorProbabilities::defaultsOf(UpdatePolicy::netEvidence);
        p.scanMissMin = scanMissMin;
        SensorModel{p};
    }
    IntegratorOptions options;
    options.threads = threads;
    options.validate();
    poseNoise.validate();
    if (slice) validateSlice(*slice);
}

std::vector<AccuracyTable> runAccuracy(const AccuracyRequest& request, std::ostream& log,
                                       ProgressMeter::Style style) {
    request.validate();
    std::vector<AccuracyTable> tables;
    for (const std::string& data : request.data) {
        PointScanRequest load{data, request.source, request.worldSeed};
        const PointScans scans = loadPointScans(load);
        std::optional<SimulatedWorld> world;
        std::optional<PointScans> exact;
        if (SimulatedWorld::isName(data)) {
            world.emplace(data, request.worldSeed);
            load.noise = RangeNoise::none;
            exact = loadPointScans(load);
        }
        for (const double resolution : request.resolutions) {
            log << scans.name << ", " << resolution << " m" << std::endl;
            const AccuracyCase c = makeCase(request, scans, exact ? &*exact : nullptr,
                                            world ? &*world : nullptr, resolution);
            AccuracyTable table;
            table.data = scans.name;
            table.resolution = resolution;
            table.scans = scans.scans.size();
            table.points = scans.points;
            std::vector<SlicePanel> panels;
            table.rows = runRows(c, log, style, panels);
            if (!panels.empty()) table.picture = drawSlices(panels, resolution);
            tables.push_back(std::move(table));
        }
    }
    return tables;
}

}  // namespace superray
