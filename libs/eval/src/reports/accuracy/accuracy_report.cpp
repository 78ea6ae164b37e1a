// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/accuracy.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "text/text_table.h"

namespace superray {
namespace {

using Json = nlohmann::ordered_json;

std::string percent(double share, int digits = 1) {
    return formatFixed(100 * share, digits);
}

double shareOf(std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::vector<std::string> namesOf(const AccuracyRow& row) {
    return {row.engine, row.policy, row.model};
}

/// A table of which the first three columns name the map.
class MapTable {
 public:
    explicit MapTable(const std::vector<std::string>& columns)
        : table_(joined({"engine", "policy", "model"}, columns)) {}
    void add(const AccuracyRow& row, const std::vector<std::string>& values) {
        table_.add(joined(namesOf(row), values));
    }
    std::string text() const { return table_.text(); }

 private:
    static std::vector<std::string> joined(std::vector<std::string> a,
                                           const std::vector<std::string>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    }
    TextTable table_;
};

std::string scoreTable(const AccuracyTable& t) {
    MapTable table({"accuracy", "occupied", "free", "occ. unknown", "free unknown", "at 0.5",
                    "occ. 0.5", "free 0.5", "AUC", "ceiling"});
    for (const AccuracyRow& row : t.rows) {
        const AccuracyScore& s = row.score;
        table.add(row, {percent(s.all().share()), percent(s.occupied.share()),
                        percent(s.free.share()),
                        percent(shareOf(s.occupied.unknown, s.occupied.tested)),
                        percent(shareOf(s.free.unknown, s.free.tested)),
                        percent(s.all().shareAtHalf()), percent(s.occupied.shareAtHalf()),
                        percent(s.free.shareAtHalf()), s.auc ? formatFixed(*s.auc, 4) : "-",
                        percent(shareOf(s.ceiling, s.all().tested))});
    }
    return table.text();
}

std::string truthTable(const AccuracyTable& t) {
    MapTable table({"IoU", "complete points", "complete cells", "free said occupied", "kept",
                    "false", "missed"});
    for (const AccuracyRow& row : t.rows) {
        const TruthScore& s = *row.truth;
        table.add(row,
                  {percent(s.iou()), percent(s.completeness()), percent(s.cellCompleteness()),
                   percent(s.freeSaidOccupied(), 2), formatCount(s.occupiedSolid),
                   formatCount(s.occupiedFree), formatCount(s.missed)});
    }
    return table.text();
}

std::string movingTable(const AccuracyTable& t) {
    MapTable table(
        {"detected rays", "detected cells", "walker cells", "t50", "box cells", "ghosts"});
    for (const AccuracyRow& row : t.rows) {
        const MovingScore& s = *row.moving;
        table.add(row, {percent(s.detectedRayShare()), percent(s.detectedCellShare()),
                        formatCount(s.walkerCells),
                        s.scansToHalf ? std::to_string(*s.scansToHalf) : "-",
                        formatCount(s.boxCells), formatCount(s.ghosts)});
    }
    return table.text();
}

std::string bandName(const AccuracyBand& band) {
    if (std::isinf(band.to)) return "from " + formatFixed(band.from, 0);
    return formatFixed(band.from, 0) + "-" + formatFixed(band.to, 0);
}

/// Shares that are right, by band: of both kinds, or of the occupied points alone.
std::string bandTable(const AccuracyTable& t, std::vector<AccuracyBand> AccuracyRow::*bands) {
    std::vector<std::string> names;
    for (const AccuracyBand& band : t.rows.front().*bands) names.push_back(bandName(band));
    MapTable table(names);
    for (const AccuracyRow& row : t.rows) {
        std::vector<std::string> values;
        for (const AccuracyBand& band : row.*bands) {
            std::string value = band.occupied.tested > 0 ? percent(band.occupied.share()) : "-";
            if (band.free.tested > 0) value += " / " + percent(band.free.share());
            values.push_back(value);
        }
        table.add(row, values);
    }
    return table.text();
}

Json asJson(const ClassScore& s) {
    return {{"tested", s.tested},
            {"right", s.right},
            {"right_at_half", s.rightAtHalf},
            {"unknown", s.unknown}};
}

Json asJson(const std::vector<AccuracyBand>& bands) {
    Json list = Json::array();
    for (const AccuracyBand& band : bands)
        list.push_back({{"from", band.from},
                        {"to", std::isinf(band.to) ? Json(nullptr) : Json(band.to)},
                        {"occupied", asJson(band.occupied)},
                        {"free", asJson(band.free)}});
    return list;
}

Json asJson(const TruthScore& s) {
    return {{"iou", s.iou()},
            {"completeness", s.completeness()},
            {"cell_completeness", s.cellCompleteness()},
            {"free_said_occupied", s.freeSaidOccupied()},
            {"cells_occupied_solid", s.occupiedSolid},
            {"cells_occupied_free", s.occupiedFree},
            {"cells_missed", s.missed},
            {"cells_known_free", s.knownFree},
            {"cells_seen", s.seenCells},
            {"points_seen", s.seenPoints},
            {"points_kept", s.seenPointsKept}};
}

Json asJson(const MovingScore& s) {
    return {{"walker_cells", s.walkerCells},
            {"detected", s.detected},
            {"walker_rays", s.walkerRays},
            {"detected_rays", s.detectedRays},
            {"ghosts", s.ghosts},
            {"box_cells", s.boxCells},
            {"scans_to_half", s.scansToHalf ? Json(*s.scansToHalf) : Json(nullptr)}};
}

Json rowAsJson(const AccuracyRequest& request, const AccuracyTable& t, const AccuracyRow& row) {
    Json json = {{"data", t.data},
                 {"resolution", t.resolution},
                 {"scans", t.scans},
                 {"points", t.points},
                 {"world_seed", request.worldSeed},
                 {"test_seed", request.testSeed},
                 {"pose_noise_metres", request.poseNoise.metres},
                 {"pose_noise_degrees", request.poseNoise.degrees},
                 {"engine", row.engine},
                 {"policy", row.policy},
                 {"model", row.model},
                 {"weights", row.weights}};
    if (row.moving) {
        json["moving"] = asJson(*row.moving);
        return json;
    }
    const AccuracyScore& s = row.score;
    json["accuracy"] = s.all().share();
    json["accuracy_at_half"] = s.all().shareAtHalf();
    json["auc"] = s.auc ? Json(*s.auc) : Json(nullptr);
    json["ceiling"] = shareOf(s.ceiling, s.all().tested);
    json["occupied"] = asJson(s.occupied);
    json["free"] = asJson(s.free);
    json["by_range"] = asJson(row.byRange);
    if (!row.byIncidence.empty()) json["by_incidence"] = asJson(row.byIncidence);
    if (row.truth) json["truth"] = asJson(*row.truth);
    return json;
}

void writeTable(std::ostringstream& out, const AccuracyTable& t) {
    if (t.rows.front().moving) {
        out << "Moving things\n" << movingTable(t);
        return;
    }
    out << "Test points, right [%]\n" << scoreTable(t);
    if (t.rows.front().truth) out << "\nAgainst the exact geometry [%]\n" << truthTable(t);
    out << "\nOccupied / free points right, by range [m, %]\n"
        << bandTable(t, &AccuracyRow::byRange);
    if (!t.rows.front().byIncidence.empty())
        out << "\nOccupied points right, by incidence [degrees from the normal, %]\n"
            << bandTable(t, &AccuracyRow::byIncidence);
}

}  // namespace

std::string accuracyAsText(const AccuracyRequest& request,
                           const std::vector<AccuracyTable>& tables) {
    std::ostringstream out;
    for (const AccuracyTable& t : tables) {
        out << "\n"
            << t.data << ", " << t.resolution << " m, " << t.scans << " scans, "
            << formatCount(t.points / std::max<std::uint64_t>(t.scans, 1)) << " points a scan";
        if (!request.poseNoise.none())
            out << ", pose noise " << request.poseNoise.metres << " m, "
                << request.poseNoise.degrees << " degrees";
        out << "\n\n";
        writeTable(out, t);
        out << "\nWhat rays really do to a cell that is unknown before\n";
        for (const AccuracyRow& row : t.rows)
            out << "  " << row.engine << ", " << row.policy
                << (row.model == "-" ? "" : ", " + row.model) << ": " << row.weights << "\n";
    }
    return out.str();
}

std::string accuracyAsJson(const AccuracyRequest& request,
                           const std::vector<AccuracyTable>& tables) {
    Json list = Json::array();
    for (const AccuracyTable& t : tables)
        for (const AccuracyRow& row : t.rows) list.push_back(rowAsJson(request, t, row));
    const Json document = {{"program", "superray-bench accuracy"}, {"runs", list}};
    return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace superray
