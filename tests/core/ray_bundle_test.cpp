#include <superray/core/ray_bundle.h>

#include <gtest/gtest.h>

#include <limits>

namespace superray {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(RayBundle, BadPointsAreSkippedAndCounted) {
    const CellGeometry<3> g(0.1);
    RayBundle<3> rays(g, {0, 0, 0}, {0.5, kInf});
    rays.add({1, 2, 3});
    rays.add({kNan, 0, 0});
    rays.add({0, kInf, 0});
    rays.add({0, 0, -kInf});
    rays.add({0, 0, 4000});
    rays.add({0.1, 0.1, 0.1});
    EXPECT_EQ(rays.size(), 1u);
    EXPECT_EQ(rays.skipped().notFinite, 3u);
    EXPECT_EQ(rays.skipped().outOfRange, 1u);
    EXPECT_EQ(rays.skipped().tooNear, 1u);
    EXPECT_EQ(rays.skipped().total(), 5u);
}

TEST(RayBundle, FarHitsAreCutAndOpen) {
    const CellGeometry<2> g(0.1);
    RayBundle<2> rays(g, {1, 1}, {0, 5});
    rays.add({1, 4});
    rays.add({1, 11});
    rays.add({1, 1e6});  // outside the addressable range, but not after the cut
    rays.add({3, 1}, RayEnd::open);
    ASSERT_EQ(rays.size(), 4u);
    EXPECT_EQ(rays.kind(0), RayEnd::hit);
    EXPECT_EQ(rays.kind(1), RayEnd::open);
    EXPECT_NEAR((rays.end(1) - Point<2>(1, 6)).norm(), 0, 1e-12);
    EXPECT_EQ(rays.kind(2), RayEnd::open);
    EXPECT_NEAR((rays.end(2) - Point<2>(1, 6)).norm(), 0, 1e-9);
    EXPECT_EQ(rays.kind(3), RayEnd::open);
    EXPECT_EQ(rays.skipped().total(), 0u);
}

TEST(RayBundle, OriginsPerRay) {
    const CellGeometry<2> g(0.1);
    RayBundle<2> rays(g, {0, 0});
    rays.add({1, 0});
    EXPECT_TRUE(rays.hasCommonOrigin());
    rays.add({0.5, 0.5}, {2, 0}, RayEnd::hit);
    rays.add({kNan, 0.5}, {2, 0}, RayEnd::hit);
    rays.add({0.7, 0.5}, {kNan, 0}, RayEnd::hit);
    rays.add({0.6, 0.5}, {3, 0}, RayEnd::open);
    ASSERT_EQ(rays.size(), 3u);
    EXPECT_FALSE(rays.hasCommonOrigin());
    EXPECT_EQ(rays.origin(0), Point<2>(0, 0));
    EXPECT_EQ(rays.origin(1), Point<2>(0.5, 0.5));
    EXPECT_EQ(rays.origin(2), Point<2>(0.6, 0.5));
    EXPECT_EQ(rays.skipped().notFinite, 2u);
}

TEST(RayBundle, BadOriginAndLimitsThrow) {
    const CellGeometry<2> g(0.1);
    EXPECT_THROW((RayBundle<2>(g, {kNan, 0})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {1e9, 0})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {0, 0}, {-1, 5})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {0, 0}, {5, 5})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {0, 0}, {0, kNan})), std::invalid_argument);
}

}  // namespace
}  // namespace superray
