// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file octomap_tree_engine.h
/// What the engines around an octomap::OcTree share.

#include <octomap/OcTree.h>
#include <superray/storage/block_grid.h>

#include "engines/bench_engines.h"

namespace superray {

/// All leaves of a tree as cells.
BlockGrid<3> cellsOf(const octomap::OcTree& tree);

class OctomapTreeEngine : public BenchEngine {
 public:
    explicit OctomapTreeEngine(const BenchEngineOptions& options) : tree_(options.resolution) {
        setSensorModel(tree_, options.peerModel);
    }

    void prepare(const PointScan& scan) override {
        cloud_.clear();
        cloud_.reserve(scan.points.size());
        for (const Eigen::Vector3f& p : scan.points) cloud_.push_back(p.x(), p.y(), p.z());
        origin_ = octomap::point3d(scan.origin.x(), scan.origin.y(), scan.origin.z());
    }
    std::size_t mapBytes() const override { return tree_.memoryUsage(); }
    std::string digest() const override { return contentDigest<3>(cellsOf(tree_)); }
    std::optional<double> occupancy(const Eigen::Vector3f& p) const override {
        const auto* node = tree_.search(double{p.x()}, double{p.y()}, double{p.z()});
        if (node == nullptr) return std::nullopt;
        return node->getOccupancy();
    }

 protected:
    octomap::OcTree tree_;
    octomap::Pointcloud cloud_;
    octomap::point3d origin_;
};

}  // namespace superray
