// SPDX-License-Identifier: BSD-3-Clause
// The view that follows a map by blocks equals one made afresh.

#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/storage/block_grid.h>

#include <set>
#include <tuple>

#include "maps/test_scans.h"
#include "views/voxel_view.h"

namespace superray {
namespace {

using mrpt::opengl::COctoMapVoxels;

COctoMapVoxels::Ptr viewOf(const mrpt::maps::CMetricMap& map) {
    mrpt::opengl::CSetOfObjects objects;
    map.getVisualizationInto(objects);
    return objects.getByClass<COctoMapVoxels>();
}

/// All that is drawn, in any order.
using Drawn =
    std::multiset<std::tuple<std::size_t, float, float, float, double, int, int, int>>;
Drawn drawnBy(const COctoMapVoxels& voxels) {
    Drawn drawn;
    for (std::size_t s = 0; s < voxels.getVoxelSetCount(); ++s)
        for (std::size_t i = 0; i < voxels.getVoxelCount(s); ++i) {
            const auto& v = voxels.getVoxel(s, i);
            drawn.insert({s, v.coords.x, v.coords.y, v.coords.z, v.side_length, v.color.R,
                          v.color.G, v.color.B});
        }
    return drawn;
}

void expectEqualViews(const COctoMapVoxels& a, const COctoMapVoxels& b) {
    EXPECT_EQ(drawnBy(a), drawnBy(b));
    EXPECT_EQ(a.getGridCubeCount(), b.getGridCubeCount());
    const auto boxA = a.getBoundingBox(), boxB = b.getBoundingBox();
    EXPECT_EQ(boxA.min, boxB.min);
    EXPECT_EQ(boxA.max, boxB.max);
}

/// A copy of a map has no view to start from.
template <class Map>
void expectViewLikeThatOfACopy(const Map& map) {
    expectEqualViews(*viewOf(map), *viewOf(Map(map)));
}

template <class Map>
class Views : public ::testing::Test {};
using Maps = ::testing::Types<CSuperRayGridMap2D, CSuperRayQuadMap, CSuperRayGridMap3D,
                              CSuperRayOctoMap>;
TYPED_TEST_SUITE(Views, Maps);

TYPED_TEST(Views, FollowScansAndOptions) {
    TypeParam map(0.2);
    std::size_t views = 0, most = 0;
    const auto insertAndCompare = [&](unsigned seeds) {
        for (unsigned seed = 0; seed < seeds; ++seed, ++views) {
            // Some poses come back, so that cells are freed again.
            const mrpt::poses::CPose3D pose(0.8 * (seed % 4), -0.3 * (seed % 3), 0.2 * seed);
            ASSERT_TRUE(map.insertObservation(*test::randomCloud(300, seed), pose));
            expectViewLikeThatOfACopy(map);
            most = std::max(most, viewOf(map)->getVoxelCount(0));
        }
    };
    insertAndCompare(12);
    map.renderingOptions.generateFreeVoxels = true;
    insertAndCompare(4);
    map.renderingOptions.colour = VoxelColour::occupancy;
    map.renderingOptions.generateGridLines = true;
    insertAndCompare(4);
    map.renderingOptions = {};
    map.insertionOptions.occupancyThres = 0.3;  // a missed cell counts as occupied
    insertAndCompare(4);
    map.insertionOptions.occupancyThres = 0.8;
    insertAndCompare(4);
    // A model that the integrator counts exactly for.
    map.insertionOptions.probMiss = 0.4999;
    insertAndCompare(3);
    map.clear();
    expectViewLikeThatOfACopy(map);
    insertAndCompare(3);
    map = TypeParam(0.1);
    expectViewLikeThatOfACopy(map);
    insertAndCompare(3);
    EXPECT_EQ(views, 37u);
    EXPECT_GT(most, 200u);
}

TEST(VoxelView, ReadsOnlyWhatChanged) {
    const SensorModel model{SensorProbabilities{}};
    BlockGrid<3> map(CellGeometry<3>(0.1));
    VoxelView<3> view;
    UpdateBatch<3> scan;
    for (int b = 0; b < 100; ++b) scan.hitsOf(scan.addBlock({b, 0, 0}))[7] = 1;
    const auto apply = [&](const UpdateBatch<3>& batch) {
        view.applied(batch);
        map.apply(batch, model, UpdatePolicy::everyRay);
    };
    apply(scan);
    TRenderingOptions options;
    EXPECT_EQ(view.draw(map, model, options)->getVoxelCount(0), 100u);
    EXPECT_EQ(view.blocksRead(), 100u);
    EXPECT_EQ(view.draw(map, model, options)->getVoxelCount(0), 100u);
    EXPECT_EQ(view.blocksRead(), 0u);

    UpdateBatch<3> next;
    next.hitsOf(next.addBlock({200, 0, 0}))[3] = 1;  // new: one more voxel
    next.missesOf(next.addBlock({5, 0, 0}))[7] = 9;  // the voxel there goes
    next.missesOf(next.addBlock({6, 0, 0}))[9] = 1;  // a voxel stays
    next.missesOf(next.addBlock({0, 9, 9}))[0] = 1;  // nothing drawn there, nor now
    apply(next);
    apply(next);
    EXPECT_EQ(view.draw(map, model, options)->getVoxelCount(0), 100u);
    EXPECT_EQ(view.blocksRead(), 3u);

    options.visibleOccupiedVoxels = false;  // no reason to read the map again
    EXPECT_FALSE(view.draw(map, model, options)->areVoxelsVisible(0));
    EXPECT_EQ(view.blocksRead(), 0u);
    options.generateFreeVoxels = true;
    EXPECT_EQ(view.draw(map, model, options)->getVoxelCount(1), 3u);
    EXPECT_EQ(view.blocksRead(), 102u);
    view.forget();
    view.draw(map, model, options);
    EXPECT_EQ(view.blocksRead(), 102u);
}

}  // namespace
}  // namespace superray
