// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/pose_chooser.h"

#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>

namespace superray {
namespace {

std::string listLabels(const PoseStreamsByLabel& all) {
    std::string text;
    for (const auto& [label, stream] : all)
        text += (text.empty() ? "'" : ", '") + label + "' (" +
                std::to_string(stream.entries.size()) + ")";
    return text;
}

const char* kindName(PoseOrigin kind) {
    return kind == PoseOrigin::robotPoses ? "robot poses"
           : kind == PoseOrigin::odometry ? "odometry"
                                          : "actions";
}

}  // namespace

std::string PoseCandidate::name() const {
    const std::string text = kindName(kind);
    return kind == PoseOrigin::actions ? text : text + " '" + label + "'";
}

std::string PoseChooser::list(const PoseStreams& streams) {
    std::string text;
    const auto add = [&](const std::string& kind) {
        text += (text.empty() ? "" : "; ") + kind;
    };
    if (!streams.robotPoses.empty()) add("robot poses " + listLabels(streams.robotPoses));
    if (!streams.odometry.empty()) add("odometry " + listLabels(streams.odometry));
    if (!streams.actions.empty())
        add("actions (" + std::to_string(streams.actions.entries.size()) + ")");
    return text.empty() ? "none" : text;
}

PoseChooser::PoseChooser(const PoseStreams& streams, const ScanSourceOptions& options,
                         const std::string& what)
    : streams_(streams),
      origin_(options.poses),
      labels_(splitList(options.poseLabel)),
      what_(what) {
    for (const auto& label : labels_) {
        const bool known =
            (asksFor(PoseOrigin::robotPoses) && streams_.robotPoses.count(label) > 0) ||
            (asksFor(PoseOrigin::odometry) && streams_.odometry.count(label) > 0);
        if (!known)
            throw InputError(what_ + ": has no poses with the label '" + label +
                             "' (--pose-label, --pose-source " + toString(origin_) +
                             "); it has: " + list(streams_));
    }
}

bool PoseChooser::asksFor(PoseOrigin kind) const {
    if (origin_ == PoseOrigin::input) return true;
    if (origin_ == PoseOrigin::motion) return kind != PoseOrigin::robotPoses;
    return origin_ == kind;
}

std::optional<PoseCandidate> PoseChooser::only(PoseOrigin kind,
                                               const PoseStreamsByLabel& all) const {
    if (!asksFor(kind)) return std::nullopt;
    std::vector<PoseCandidate> found;
    for (const auto& [label, stream] : all) {
        const bool wanted = labels_.empty() ||
                            std::find(labels_.begin(), labels_.end(), label) != labels_.end();
        if (wanted && !stream.empty()) found.push_back({kind, label, &stream});
    }
    if (found.empty()) return std::nullopt;
    if (found.size() > 1)
        throw InputError(what_ + ": has " + kindName(kind) + " of " +
                         std::to_string(found.size()) + " labels, " + listLabels(all) +
                         ", which may be in different frames; choose one (--pose-label)");
    return found.front();
}

std::optional<PoseCandidate> PoseChooser::robotPoses() const {
    return only(PoseOrigin::robotPoses, streams_.robotPoses);
}

std::optional<PoseCandidate> PoseChooser::motion() const {
    std::optional<PoseCandidate> actions;
    if (asksFor(PoseOrigin::actions) && labels_.empty() && !streams_.actions.empty())
        actions = PoseCandidate{PoseOrigin::actions, "", &streams_.actions};
    const bool mostTell = streams_.actions.entries.size() > streams_.emptyActions;
    if (actions && ((mostTell && streams_.actionsMove) || streams_.odometry.empty()))
        return actions;
    auto odometry = only(PoseOrigin::odometry, streams_.odometry);
    return odometry ? odometry : actions;
}

}  // namespace superray
