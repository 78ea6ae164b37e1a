// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file frame_tree.h
/// Where the frames of a recording are to each other, over time (tf).

#include <superray/maps/pose_track.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sources/ros/ros_messages.h"

namespace superray {

/// Which topic told a transform.
enum class TransformTopic : std::uint8_t {
    fixed,  ///< /tf_static: holds at all times
    moving  ///< /tf
};

/// A transform as it was told.
struct TransformSample {
    mrpt::Clock::time_point time;
    std::uint64_t order;  ///< number of its message
    RosPose pose;
};

/// All that is told of one frame in its parent.
class FrameLink {
 public:
    FrameLink(std::string child, std::string parent)
        : child_(std::move(child)), parent_(std::move(parent)) {}

    const std::string& child() const { return child_; }
    const std::string& parent() const { return parent_; }

    /// Middle ones of equal samples within `bridge` [s] are dropped: those about them tell
    /// the same.
    void add(const TransformSample& sample, TransformTopic topic, double bridge);

    /// Told by /tf_static only.
    bool isFixed() const { return moving_.empty(); }
    /// What /tf_static told twice, or /tf otherwise than it, in words; empty: nothing.
    const std::string& contradiction() const { return contradiction_; }
    /// Told by /tf_static, or always the same by /tf, too.
    bool neverChanges() const { return isFixed() || !changes_; }
    /// Those of /tf, in the order of the file.
    const std::vector<TransformSample>& moving() const { return moving_; }

    /// T_parent_child. One that never changes holds at all times.
    PoseAnswer at(mrpt::Clock::time_point time, const PoseLimits& limits) const;

 private:
    void compareWithFixed(const RosPose& told, TransformTopic topic);

    std::string child_, parent_;
    std::optional<RosPose> fixed_;  // the first that was told
    std::string contradiction_;
    bool changes_ = false;
    std::vector<TransformSample> moving_;
    mutable std::unique_ptr<PoseTrack> track_;  // made when first asked for
};

/// Links from a frame upwards to one of its ancestors.
struct FrameChain {
    std::vector<const FrameLink*> links;  ///< the lowest first

    bool isFixed() const;
    bool neverChanges() const;
    /// The first of its links; see there.
    std::string contradiction() const;
    /// T_ancestor_frame.
    PoseAnswer at(mrpt::Clock::time_point time, const PoseLimits& limits) const;
};

/// A way from a frame up to a common ancestor, and down to another.
struct FramePath {
    FrameChain up, down;

    bool neverChanges() const { return up.neverChanges() && down.neverChanges(); }
    /// The first of its links; see there.
    std::string contradiction() const;
    /// Its frames after the first one: "'imu', 'base_link'".
    std::string asText() const;
    /// T_to_from.
    PoseAnswer at(mrpt::Clock::time_point time, const PoseLimits& limits) const;
};

/// A transform that was told, and is none.
struct DroppedTransform {
    std::string child, parent, why;
};

class FrameTree {
 public:
    /// \param bridge see FrameLink::add() [s]
    explicit FrameTree(double bridge) : bridge_(bridge) {}

    /// \return false if it is dropped, as it is no rotation or not finite
    bool add(const RosTransform& transform, TransformTopic topic, std::uint64_t order);

    bool empty() const { return links_.empty(); }
    bool has(const std::string& frame) const;
    /// Transforms that were dropped, of frames that no other tells: the first of each two
    /// frames.
    std::vector<DroppedTransform> dropped() const;
    /// All frames, by name.
    std::vector<std::string> frames() const;

    /// Ancestors of a frame, nearest first, each by a shortest chain; the frame itself comes
    /// first, with an empty one. Frames told with two parents have those of both.
    struct Ancestor {
        std::string frame;
        FrameChain chain;
        bool isRoot;
    };
    std::vector<Ancestor> ancestors(const std::string& frame) const;

    /// From a frame to another one. Downwards it goes by /tf_static only: what is given in
    /// a frame that the robot moves in does not tell where the sensor is.
    std::optional<FramePath> path(const std::string& from, const std::string& to) const;

    /// Ways by each parent of the frames that have several: one of them may be path(). Some
    /// of them, if there are very many. Empty where no frame has several.
    std::vector<FramePath> pathsByParents(const std::string& from, const std::string& to) const;

 private:
    void addPathsUp(const std::string& from, const std::string& to,
                    std::vector<FramePath>& paths) const;
    void addPathsDown(const std::string& from, const std::string& to,
                      std::vector<FramePath>& paths) const;

    double bridge_;
    std::map<std::string, std::map<std::string, FrameLink>> links_;  // by child, then parent
    std::map<std::pair<std::string, std::string>, std::string> dropped_;  // likewise: why
};

}  // namespace superray
