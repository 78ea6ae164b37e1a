// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/map_build.h>
#include <superray/eval/progress_meter.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace superray {
namespace {

/// A line "  name   number  note", left out if the number is 0.
void addCount(std::ostream& out, const char* name, std::uint64_t number,
              const char* note = "") {
    if (number == 0) return;
    out << "  " << name << formatCount(number) << note << "\n";
}

}  // namespace

std::string describe(const BuildReport& r) {
    const auto& i = r.insertion;
    std::ostringstream out;
    out << "scans      " << formatCount(r.scans) << " in " << formatSeconds(r.totalSeconds)
        << "\n"
        << "rays       " << formatCount(i.rays) << "\n";
    for (const auto& poses : r.poses)
        if (!poses.empty()) out << "poses: " << poses << "\n";
    out << "time       reading " << formatSeconds(r.readSeconds) << ", rays "
        << formatSeconds(i.toRaysSeconds) << ", integration "
        << formatSeconds(i.integrateSeconds) << ", map update " << formatSeconds(i.applySeconds)
        << "\n";
    std::ostringstream skipped;
    addCount(skipped, "scans outside the time of the poses    ", r.skipped.withoutPose);
    addCount(skipped, "scans in a gap between two poses       ", r.skipped.inPoseGap);
    addCount(skipped, "scans without a time stamp             ", r.skipped.withoutTime);
    addCount(skipped, "poses not finite                       ", r.skipped.badPoses);
    addCount(skipped, "scans of another sensor                ", r.skipped.otherLabel);
    addCount(skipped, "scans without usable ranges or points  ", r.unusable);
    addCount(skipped, "scans of planar scanners too tilted    ", r.tiltedScans);
    addCount(skipped, "points not finite                      ", i.skipped.notFinite);
    addCount(skipped, "points outside the addressable cells   ", i.skipped.outOfRange);
    addCount(skipped, "points nearer than the minimum range   ", i.skipped.tooNear);
    addCount(skipped, "points outside the height band         ", i.outOfHeightBand);
    addCount(skipped, "rays outside the time of the poses     ", i.withoutPose);
    addCount(skipped, "measurements without return            ", i.noReturns);
    out << "left out" << (skipped.str().empty() ? "   nothing\n" : "\n" + skipped.str());
    for (const auto& warning : r.warnings) out << "warning    " << warning << "\n";
    return out.str();
}

std::string describeAsJson(const BuildReport& r, const SuperRayMapInterface& map,
                           const std::string& output) {
    using Json = nlohmann::ordered_json;
    const auto& i = r.insertion;
    const auto cells = map.cellTotals();
    const Json json{
        {"scans", r.scans},
        {"rays", i.rays},
        {"poses", r.poses},
        {"seconds",
         {{"total", r.totalSeconds},
          {"reading", r.readSeconds},
          {"rays", i.toRaysSeconds},
          {"integration", i.integrateSeconds},
          {"map_update", i.applySeconds}}},
        {"left_out",
         {{"scans_outside_poses", r.skipped.withoutPose},
          {"scans_in_pose_gap", r.skipped.inPoseGap},
          {"scans_without_time", r.skipped.withoutTime},
          {"scans_of_other_sensor", r.skipped.otherLabel},
          {"scans_unusable", r.unusable},
          {"scans_tilted", r.tiltedScans},
          {"poses_not_finite", r.skipped.badPoses},
          {"points_not_finite", i.skipped.notFinite},
          {"points_out_of_range", i.skipped.outOfRange},
          {"points_too_near", i.skipped.tooNear},
          {"points_out_of_height_band", i.outOfHeightBand},
          {"rays_outside_poses", i.withoutPose},
          {"without_return", i.noReturns}}},
        {"warnings", r.warnings},
        {"cells", {{"known", cells.known}, {"occupied", cells.occupied}, {"free", cells.free}}},
        {"digest", map.digest()},
        {"output", output}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace superray
