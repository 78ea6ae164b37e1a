// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/order_pairing.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace superray {
namespace {

enum class Side { before, after };

/// Index of the last pose before the scan, or of the first one after it.
std::optional<std::size_t> neighbour(const std::vector<PoseEntry>& poses, std::uint64_t order,
                                     Side side) {
    const auto after =
        std::upper_bound(poses.begin(), poses.end(), order,
                         [](std::uint64_t o, const PoseEntry& p) { return o < p.place.order; });
    if (side == Side::before && after == poses.begin()) return std::nullopt;
    if (side == Side::after && after == poses.end()) return std::nullopt;
    const auto chosen = side == Side::before ? std::prev(after) : after;
    return static_cast<std::size_t>(chosen - poses.begin());
}

/// The pose in the frame of the scan.
std::optional<std::size_t> inSameGroup(const std::vector<PoseEntry>& poses, const Place& scan) {
    for (const Side side : {Side::before, Side::after})
        if (const auto i = neighbour(poses, scan.order, side))
            if (poses[*i].place.group == scan.group) return i;
    return std::nullopt;
}

}  // namespace

PosesByOrder pairByOrder(const std::vector<PoseEntry>& poses,
                         const std::vector<ScanPlace>& scans, const std::string& what) {
    const auto fail = [&](const std::string& why) {
        throw InputError(what +
                         ": time stamps do not tell which pose belongs to which scan, nor does "
                         "their order: " +
                         why + "; give a poses file (--poses FILE), or choose other poses");
    };
    PosesByOrder pairs;
    if (scans.empty()) return pairs;
    const bool poseFirst = poses.front().place.order < scans.front().place.order;
    const bool poseLast = poses.back().place.order > scans.back().place.order;
    std::set<std::pair<std::size_t, unsigned>> taken;
    for (const ScanPlace& scan : scans) {
        auto pose = inSameGroup(poses, scan.place);
        if (!pose && !poseFirst && !poseLast)
            fail("a scan comes first, and one last, of " + std::to_string(scans.size()) +
                 " scans and " + std::to_string(poses.size()) + " poses");
        if (!pose)
            pose = neighbour(poses, scan.place.order, poseFirst ? Side::before : Side::after);
        if (!pose) fail("a scan has no pose on its side");
        if (!taken.emplace(*pose, scan.sensor).second)
            fail("one sensor has several scans to one pose");
        pairs[scan.place.order] = *pose;
    }
    return pairs;
}

}  // namespace superray
