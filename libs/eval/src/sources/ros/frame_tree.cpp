// SPDX-License-Identifier: BSD-3-Clause
#include "sources/ros/frame_tree.h"

#include <algorithm>
#include <set>
#include <utility>

namespace superray {

using mrpt::poses::CPose3D;
using Time = mrpt::Clock::time_point;

/// Robots have a dozen frames above each other; files that are damaged may have any number.
constexpr std::size_t kDeepest = 100;

void FrameLink::add(const TransformSample& sample, TransformTopic topic, double bridge) {
    if (topic == TransformTopic::fixed) {
        isContradicted_ = isContradicted_ || (fixed_ && !(*fixed_ == sample.pose));
        fixed_ = sample.pose;
        return;
    }
    track_.reset();
    changes_ = changes_ || (!moving_.empty() && !(moving_.back().pose == sample.pose));
    if (moving_.size() >= 2) {
        const TransformSample& before = moving_[moving_.size() - 2];
        TransformSample& middle = moving_.back();
        const double seconds = secondsBetween(before.time, sample.time);
        const bool isInOrder = before.time <= middle.time && middle.time <= sample.time;
        if (before.pose == middle.pose && middle.pose == sample.pose && isInOrder &&
            seconds <= bridge) {
            middle = sample;
            return;
        }
    }
    moving_.push_back(sample);
}

PoseAnswer FrameLink::at(Time time, const PoseLimits& limits) const {
    if (isFixed() || !changes_) {
        const RosPose& pose = isFixed() ? *fixed_ : moving_.front().pose;
        return {PoseAnswer::Result::found, pose.asPose()};
    }
    if (!track_) {
        track_ = std::make_unique<PoseTrack>();
        for (const TransformSample& s : moving_)
            if (const auto pose = s.pose.asPose()) track_->add(s.time, *pose);
    }
    return track_->lookUp(time, limits);
}

bool FrameChain::isFixed() const {
    return std::all_of(links.begin(), links.end(),
                       [](const FrameLink* link) { return link->isFixed(); });
}

bool FrameChain::isContradicted() const {
    return std::any_of(links.begin(), links.end(),
                       [](const FrameLink* link) { return link->isContradicted(); });
}

PoseAnswer FrameChain::at(Time time, const PoseLimits& limits) const {
    CPose3D pose;
    for (const FrameLink* link : links) {
        const PoseAnswer step = link->at(time, limits);
        if (!step.pose) return step;
        pose = *step.pose + pose;
    }
    return {PoseAnswer::Result::found, pose};
}

PoseAnswer FramePath::at(Time time, const PoseLimits& limits) const {
    PoseAnswer upwards = up.at(time, limits);
    if (down.links.empty() || !upwards.pose) return upwards;
    const PoseAnswer downwards = down.at(time, limits);
    if (!downwards.pose) return downwards;
    upwards.pose = *upwards.pose - *downwards.pose;
    return upwards;
}

bool FrameTree::add(const RosTransform& transform, TransformTopic topic, std::uint64_t order) {
    if (!transform.pose.asPose() || transform.child == transform.header.frame) return false;
    links_[transform.child][transform.header.frame].add(
        {transform.header.time, order, transform.pose}, topic, bridge_);
    return true;
}

bool FrameTree::has(const std::string& frame) const {
    if (links_.count(frame) > 0) return true;
    return std::any_of(links_.begin(), links_.end(),
                       [&](const auto& child) { return child.second.count(frame) > 0; });
}

std::vector<std::string> FrameTree::frames() const {
    std::set<std::string> names;
    for (const auto& [child, parents] : links_) {
        names.insert(child);
        for (const auto& parent : parents) names.insert(parent.first);
    }
    return {names.begin(), names.end()};
}

std::vector<FrameTree::Ancestor> FrameTree::ancestors(const std::string& frame) const {
    std::vector<Ancestor> found{{frame, {}, links_.count(frame) == 0}};
    std::set<std::string> seen{frame};
    for (std::size_t i = 0; i < found.size(); ++i) {  // nearest first; grows
        const auto parents = links_.find(found[i].frame);
        if (parents == links_.end() || found[i].chain.links.size() == kDeepest) continue;
        for (const auto& [parent, link] : parents->second) {
            if (!seen.insert(parent).second) continue;
            Ancestor next{parent, found[i].chain, links_.count(parent) == 0};
            next.chain.links.push_back(&link);
            found.push_back(std::move(next));
        }
    }
    return found;
}

std::optional<FramePath> FrameTree::path(const std::string& from, const std::string& to) const {
    const auto above = ancestors(from);
    std::map<std::string, const Ancestor*> byName;
    for (const Ancestor& a : above) byName[a.frame] = &a;
    for (Ancestor& common : ancestors(to)) {
        if (!common.chain.isFixed()) continue;
        const auto meets = byName.find(common.frame);
        if (meets != byName.end())
            return FramePath{meets->second->chain, std::move(common.chain)};
    }
    return std::nullopt;
}

}  // namespace superray
