// SPDX-License-Identifier: BSD-3-Clause
// Maps against simulated worlds: maps of which it is known how true they are.

#include <gtest/gtest.h>
#include <superray/core/block.h>
#include <superray/eval/incidence.h>
#include <superray/eval/moving_score.h>
#include <superray/eval/point_scan.h>
#include <superray/eval/world_truth.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace superray {
namespace {

double share(std::uint64_t part, std::uint64_t all) {
    return static_cast<double>(part) / static_cast<double>(all);
}

using CellSet = std::unordered_set<Cell<3>, IndexHash>;

/// Every `step`-th point of a world's scans, on the surface.
std::vector<PointScan> scansOf(
    const std::string& world, std::size_t step,
    std::uint64_t scans = std::numeric_limits<std::uint64_t>::max()) {
    PointScanRequest request;
    request.data = world;
    request.noise = RangeNoise::none;
    request.source.maxScans = scans;
    std::vector<PointScan> thin;
    for (const PointScan& scan : loadPointScans(request).scans) {
        thin.push_back({scan.origin, {}});
        for (std::size_t i = 0; i < scan.points.size(); i += step)
            thin.back().points.push_back(scan.points[i]);
    }
    return thin;
}

/// A map that says what a function says, which is told the scans.
class ToldEngine : public BenchEngine {
 public:
    using Occupancy = std::function<std::optional<double>(const Cell<3>&)>;
    ToldEngine(double resolution, Occupancy occupancy)
        : geometry_(resolution), occupancy_(std::move(occupancy)) {}
    void prepare(const PointScan& scan) override {
        last_.clear();
        for (const auto& p : scan.points) last_.insert(geometry_.cellOf(p.cast<double>()));
    }
    void insert() override {}
    std::size_t mapBytes() const override { return 0; }
    std::optional<double> occupancy(const Eigen::Vector3f& point) const override {
        return occupancy_(geometry_.cellOf(point.cast<double>()));
    }
    /// Whether an end point of the last scan is in the cell.
    bool hitLast(const Cell<3>& cell) const { return last_.count(cell) != 0; }

 private:
    CellGeometry<3> geometry_;
    Occupancy occupancy_;
    CellSet last_;
};

class TruthOfAWorld : public testing::Test {
 protected:
    static constexpr double kResolution = 0.2;
    SimulatedWorld world_{"indoor"};
    std::vector<PointScan> scans_ = scansOf("indoor", 20, 3);
    WorldTruth truth_{world_, kResolution, scans_, scans_};
    std::uint64_t solid_ = 0, free_ = 0, seen_ = 0, points_ = 0;
    std::unordered_map<Cell<3>, TrueCell, IndexHash> cells_;

    void SetUp() override {
        truth_.forEachCell([&](const TrueCell& cell) {
            EXPECT_TRUE(cells_.emplace(cell.cell, cell).second) << "visited twice";
            ++(cell.solid ? solid_ : free_);
            seen_ += cell.seen > 0;
            points_ += cell.seen;
        });
        ASSERT_GT(free_, 10000u);
        ASSERT_GT(seen_, 1000u);
    }
    TruthScore scoreOf(const ToldEngine::Occupancy& occupancy) const {
        return truth_.score(ToldEngine(kResolution, occupancy));
    }
};

TEST_F(TruthOfAWorld, IsThatOfTheWorldCellByCell) {
    CellSet ends;
    std::uint64_t points = 0;
    for (const PointScan& scan : scans_)
        for (const auto& p : scan.points) {
            ends.insert(truth_.geometry().cellOf(p.cast<double>()));
            ++points;
        }
    EXPECT_EQ(points_, points);
    EXPECT_EQ(seen_, ends.size());
    for (const auto& [key, cell] : cells_) {
        EXPECT_EQ(cell.seen > 0, ends.count(key) != 0);
        const Point<3> low = truth_.geometry().lowerCorner(key);
        const Eigen::AlignedBox3d box(low, low + Point<3>::Constant(kResolution));
        ASSERT_EQ(cell.solid, cell.seen > 0 || world_.touches(box));
    }
}

TEST_F(TruthOfAWorld, ATrueMapHasFullMarks) {
    const TruthScore score =
        scoreOf([&](const Cell<3>& cell) { return cells_.at(cell).solid ? 0.9 : 0.1; });
    EXPECT_EQ(score.iou(), 1);
    EXPECT_EQ(score.completeness(), 1);
    EXPECT_EQ(score.cellCompleteness(), 1);
    EXPECT_EQ(score.freeSaidOccupied(), 0);
    EXPECT_EQ(score.occupiedSolid, solid_);
    EXPECT_EQ(score.knownFree, free_);
}

TEST_F(TruthOfAWorld, MapsOfOneAnswerGetWhatTheyDeserve) {
    const TruthScore nothing = scoreOf([](const Cell<3>&) { return std::nullopt; });
    EXPECT_EQ(nothing.iou(), 0);
    EXPECT_EQ(nothing.completeness(), 0);
    EXPECT_EQ(nothing.cellCompleteness(), 0);
    EXPECT_EQ(nothing.missed, seen_);
    EXPECT_EQ(nothing.knownFree, 0u);

    const TruthScore free = scoreOf([](const Cell<3>&) { return 0.49; });
    EXPECT_EQ(free.missed, seen_);
    EXPECT_EQ(free.knownFree, free_);
    EXPECT_EQ(free.freeSaidOccupied(), 0);

    const TruthScore occupied = scoreOf([](const Cell<3>&) { return 0.5; });
    EXPECT_EQ(occupied.completeness(), 1);
    EXPECT_EQ(occupied.freeSaidOccupied(), 1);
    EXPECT_DOUBLE_EQ(occupied.iou(), share(solid_, solid_ + free_));
}

TEST_F(TruthOfAWorld, EachMistakeCounts) {
    std::uint64_t lost = 0, lostPoints = 0, invented = 0;
    for (const auto& [key, cell] : cells_) {
        const bool mistaken = IndexHash()(key) % 8 == 0;
        lost += mistaken && cell.seen > 0;
        lostPoints += mistaken ? cell.seen : 0;
        invented += mistaken && !cell.solid;
    }
    const TruthScore score = scoreOf([&](const Cell<3>& key) {
        const bool solid = cells_.at(key).solid;
        return solid != (IndexHash()(key) % 8 == 0) ? 0.8 : 0.2;
    });
    EXPECT_EQ(score.missed, lost);
    EXPECT_EQ(score.occupiedFree, invented);
    EXPECT_EQ(score.seenPoints - score.seenPointsKept, lostPoints);
    EXPECT_DOUBLE_EQ(score.cellCompleteness(), 1 - share(lost, seen_));
    EXPECT_DOUBLE_EQ(score.freeSaidOccupied(), share(invented, free_));
}

class MovingThings : public testing::Test {
 protected:
    static constexpr double kResolution = 0.2;
    SimulatedWorld world_{"walker"};
    std::vector<PointScan> scans_ = scansOf("walker", 16);

    MovingScore scoreOf(ToldEngine& engine) const {
        return scoreMoving(world_, kResolution, scans_, scans_, engine);
    }
};

TEST_F(MovingThings, MapsThatNeverForgetKeepGhosts) {
    ToldEngine always(kResolution, [](const Cell<3>&) { return 1.0; });
    const MovingScore score = scoreOf(always);
    EXPECT_GT(score.walkerCells, 20u);
    EXPECT_GE(score.walkerRays, score.walkerCells);
    EXPECT_EQ(score.detectedCellShare(), 1);
    EXPECT_EQ(score.detectedRayShare(), 1);
    EXPECT_GT(score.ghosts, score.walkerCells / 2) << "it is elsewhere in the end";
    EXPECT_LE(score.ghosts, score.walkerCells);
    EXPECT_GT(score.boxCells, 5u);
    EXPECT_FALSE(score.scansToHalf.has_value());
}

TEST_F(MovingThings, MapsThatSeeNothingDetectNothing) {
    ToldEngine never(kResolution, [](const Cell<3>&) { return 0.1; });
    const MovingScore score = scoreOf(never);
    EXPECT_GT(score.walkerCells, 20u);
    EXPECT_EQ(score.detected, 0u);
    EXPECT_EQ(score.detectedRays, 0u);
    EXPECT_EQ(score.ghosts, 0u);
    EXPECT_EQ(score.boxCells, 0u);
    EXPECT_FALSE(score.scansToHalf.has_value());
}

TEST_F(MovingThings, MapsOfTheLastScanForgetAtOnce) {
    const ToldEngine* self = nullptr;
    ToldEngine last(kResolution,
                    [&](const Cell<3>& cell) { return self->hitLast(cell) ? 0.9 : 0.1; });
    self = &last;
    const MovingScore score = scoreOf(last);
    EXPECT_EQ(score.detectedCellShare(), 1);
    EXPECT_EQ(score.ghosts, 0u);
    EXPECT_GT(score.boxCells, 5u);
    EXPECT_EQ(score.scansToHalf, 1u);
}

TEST(Incidence, IsTheAngleToTheSurfacesNormal) {
    const SimulatedWorld world("indoor");
    const Eigen::Vector3d sensor = scansOf("indoor", 1000, 1)[0].origin.cast<double>();
    std::optional<double> floor;
    int tried = 0;
    for (const double degrees : {5.0, 30.0, 60.0, 80.0}) {
        const double angle = degrees * M_PI / 180;
        const Eigen::Vector3d down(std::sin(angle), 0, -std::cos(angle));
        const auto distance = world.castRay(sensor, down);
        ASSERT_TRUE(distance.has_value());
        const Eigen::Vector3d end = sensor + *distance * down;
        if (!floor) floor = end.z();
        if (std::abs(end.z() - *floor) > 1e-6) continue;  // something stands there
        const auto incidence = incidenceOf(world, sensor, down, 0);
        ASSERT_TRUE(incidence.has_value());
        EXPECT_NEAR(*incidence, degrees, 0.01);
        ++tried;
    }
    EXPECT_GE(tried, 2);
    const SimulatedWorld outdoors("outdoor");
    const Eigen::Vector3d above(0, 0, 100);
    EXPECT_FALSE(incidenceOf(outdoors, above, {0.01, 0, 1}, 0).has_value()) << "the sky";
}

}  // namespace
}  // namespace superray
