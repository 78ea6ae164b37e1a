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
/// And a frame or two of theirs may have two parents.
constexpr std::size_t kMostPaths = 100;

/// What publishers make of one transform differs by rounding, and in the sign of the
/// quaternion [m, rad].
constexpr double kSameTransform = 1e-6;

namespace {

bool passes(const FrameChain& chain, const std::string& frame) {
    return std::any_of(chain.links.begin(), chain.links.end(), [&](const FrameLink* link) {
        return link->child() == frame || link->parent() == frame;
    });
}

void append(FrameChain& chain, const FrameLink& link, const FrameChain& rest) {
    chain.links.push_back(&link);
    chain.links.insert(chain.links.end(), rest.links.begin(), rest.links.end());
}

}  // namespace

void FrameLink::compareWithFixed(const RosPose& told, TransformTopic topic) {
    if (!contradiction_.empty() || areSame(*fixed_, told, kSameTransform)) return;
    const char* by = topic == TransformTopic::fixed ? ", and at " : ", and /tf at ";
    contradiction_ = "/tf_static tells that '" + child_ + "' is in '" + parent_ + "' at " +
                     fixed_->asText() + by + told.asText();
}

void FrameLink::add(const TransformSample& sample, TransformTopic topic, double bridge) {
    if (topic == TransformTopic::fixed) {
        if (fixed_) return compareWithFixed(sample.pose, topic);
        fixed_ = sample.pose;
        for (const TransformSample& s : moving_)
            compareWithFixed(s.pose, TransformTopic::moving);
        return;
    }
    if (fixed_) compareWithFixed(sample.pose, topic);
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
    const bool isToldFixed = isFixed() || (fixed_ && contradiction_.empty());
    if (isToldFixed || !changes_) {
        const RosPose& pose = isToldFixed ? *fixed_ : moving_.front().pose;
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

bool FrameChain::neverChanges() const {
    return std::all_of(links.begin(), links.end(),
                       [](const FrameLink* link) { return link->neverChanges(); });
}

std::string FrameChain::contradiction() const {
    for (const FrameLink* link : links)
        if (!link->contradiction().empty()) return link->contradiction();
    return "";
}

PoseAnswer FrameChain::at(Time time, const PoseLimits& limits) const {
    CPose3D pose;
    for (const FrameLink* link : links) {
        PoseAnswer step = link->at(time, limits);
        if (!step.pose) return step;
        pose = *step.pose + pose;
    }
    return {PoseAnswer::Result::found, pose};
}

std::string FramePath::contradiction() const {
    const std::string upwards = up.contradiction();
    return upwards.empty() ? down.contradiction() : upwards;
}

std::string FramePath::asText() const {
    std::string text;
    const auto add = [&](const std::string& frame) {
        text += (text.empty() ? "'" : ", '") + frame + "'";
    };
    for (const FrameLink* link : up.links) add(link->parent());
    for (auto link = down.links.rbegin(); link != down.links.rend(); ++link)
        add((*link)->child());
    return text;
}

PoseAnswer FramePath::at(Time time, const PoseLimits& limits) const {
    PoseAnswer upwards = up.at(time, limits);
    if (down.links.empty() || !upwards.pose) return upwards;
    PoseAnswer downwards = down.at(time, limits);
    if (!downwards.pose) return downwards;
    upwards.pose = *upwards.pose - *downwards.pose;
    return upwards;
}

bool FrameTree::add(const RosTransform& transform, TransformTopic topic, std::uint64_t order) {
    const std::string &child = transform.child, &parent = transform.header.frame;
    const std::string problem =
        child == parent ? "it is given in itself" : transform.pose.problem();
    if (!problem.empty()) {
        dropped_.try_emplace({child, parent}, problem);
        return false;
    }
    links_[child]
        .try_emplace(parent, child, parent)
        .first->second.add({transform.header.time, order, transform.pose}, topic, bridge_);
    return true;
}

std::vector<DroppedTransform> FrameTree::dropped() const {
    std::vector<DroppedTransform> all;
    for (const auto& [frames, why] : dropped_) {
        const auto told = links_.find(frames.first);
        if (told == links_.end() || told->second.count(frames.second) == 0)
            all.push_back({frames.first, frames.second, why});
    }
    return all;
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

std::vector<FramePath> FrameTree::pathsByParents(const std::string& from,
                                                 const std::string& to) const {
    std::vector<FramePath> paths;
    addPathsUp(from, to, paths);
    addPathsDown(from, to, paths);
    return paths;
}

/// By the parents of frames above `from`.
void FrameTree::addPathsUp(const std::string& from, const std::string& to,
                           std::vector<FramePath>& paths) const {
    if (from == to) return;
    std::size_t tried = 0;
    for (const Ancestor& a : ancestors(from)) {
        const auto parents = links_.find(a.frame);
        if (parents == links_.end() || parents->second.size() < 2 || passes(a.chain, to))
            continue;
        for (const auto& [parent, link] : parents->second) {
            if (passes(a.chain, parent)) continue;
            if (++tried > kMostPaths) return;
            auto rest = path(parent, to);
            if (!rest) continue;
            FramePath way{a.chain, std::move(rest->down)};
            append(way.up, link, rest->up);
            paths.push_back(std::move(way));
        }
    }
}

/// By the parents of frames that /tf_static tells above `to`.
void FrameTree::addPathsDown(const std::string& from, const std::string& to,
                             std::vector<FramePath>& paths) const {
    if (from == to) return;
    std::size_t tried = 0;
    for (const Ancestor& a : ancestors(to)) {
        const auto parents = links_.find(a.frame);
        if (parents == links_.end() || parents->second.size() < 2 || passes(a.chain, from) ||
            !a.chain.isFixed())
            continue;
        for (const auto& [parent, link] : parents->second) {
            if (!link.isFixed() || passes(a.chain, parent)) continue;
            if (++tried > kMostPaths) return;
            auto rest = path(from, parent);
            if (!rest) continue;
            FramePath way{std::move(rest->up), a.chain};
            append(way.down, link, rest->down);
            paths.push_back(std::move(way));
        }
    }
}

}  // namespace superray
