// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/ray_bundle.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

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
    rays.add({3, 1}, RayEnd::noReturn);
    ASSERT_EQ(rays.size(), 4u);
    EXPECT_EQ(rays.kind(0), RayEnd::hit);
    EXPECT_EQ(rays.kind(1), RayEnd::noReturn);
    EXPECT_NEAR((rays.end(1) - Point<2>(1, 6)).norm(), 0, 1e-12);
    EXPECT_EQ(rays.kind(2), RayEnd::noReturn);
    EXPECT_NEAR((rays.end(2) - Point<2>(1, 6)).norm(), 0, 1e-9);
    EXPECT_EQ(rays.kind(3), RayEnd::noReturn);
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
    rays.add({0.6, 0.5}, {3, 0}, RayEnd::noReturn);
    ASSERT_EQ(rays.size(), 3u);
    EXPECT_FALSE(rays.hasCommonOrigin());
    EXPECT_EQ(rays.origin(0), Point<2>(0, 0));
    EXPECT_EQ(rays.origin(1), Point<2>(0.5, 0.5));
    EXPECT_EQ(rays.origin(2), Point<2>(0.6, 0.5));
    EXPECT_EQ(rays.skipped().notFinite, 2u);
}

TEST(RayBundle, TheFirstRayMayHaveAnOriginOfItsOwn) {
    const CellGeometry<3> g(0.1);
    RayBundle<3> rays(g, {0, 0, 0});
    rays.add({1, 2, 3}, {1, kNan, 3}, RayEnd::hit);  // left out, and so is its origin
    EXPECT_TRUE(rays.hasCommonOrigin());
    rays.add({1, 2, 3}, {2, 2, 3}, RayEnd::hit);
    rays.add({0, 1, 0});
    ASSERT_EQ(rays.size(), 2u);
    EXPECT_FALSE(rays.hasCommonOrigin());
    EXPECT_EQ(rays.origin(0), Point<3>(1, 2, 3));
    EXPECT_EQ(rays.origin(1), Point<3>(0, 0, 0));
}

TEST(RayBundle, BadOriginAndLimitsThrow) {
    const CellGeometry<2> g(0.1);
    EXPECT_THROW((RayBundle<2>(g, {kNan, 0})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {1e9, 0})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {0, 0}, {-1, 5})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {0, 0}, {5, 5})), std::invalid_argument);
    EXPECT_THROW((RayBundle<2>(g, {0, 0}, {0, kNan})), std::invalid_argument);
}

/// Whether both bundles hold the same rays and have skipped the same points.
template <int Dim>
void expectEqual(const RayBundle<Dim>& got, const RayBundle<Dim>& expected) {
    ASSERT_EQ(got.size(), expected.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
        ASSERT_EQ(got.end(i), expected.end(i));
        ASSERT_EQ(got.origin(i), expected.origin(i));
        ASSERT_EQ(got.kind(i), expected.kind(i));
    }
    EXPECT_EQ(got.skipped().notFinite, expected.skipped().notFinite);
    EXPECT_EQ(got.skipped().outOfRange, expected.skipped().outOfRange);
    EXPECT_EQ(got.skipped().tooNear, expected.skipped().tooNear);
    EXPECT_EQ(got.lowest(), expected.lowest());
    EXPECT_EQ(got.highest(), expected.highest());
}

template <int Dim, typename Scalar>
void checkManyReturns(double badShare, const RangeLimits& limits) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> coordinate(-40, 40), share(0, 1);
    const CellGeometry<Dim> g(0.1);
    RayBundle<Dim> one(g, Point<Dim>::Constant(0.03), limits), many = one;
    std::size_t bad = 0;
    for (std::size_t count : {0u, 1u, 255u, 256u, 1000u}) {
        std::vector<Scalar> points;
        for (std::size_t i = 0; i < count * Dim; ++i)
            points.push_back(static_cast<Scalar>(coordinate(random)));
        for (Scalar& x : points) {
            const double draw = share(random);
            if (draw >= badShare) continue;
            ++bad;
            const double kinds[] = {kNan, kInf, -kInf, 1e4, -1e4};
            x = static_cast<Scalar>(kinds[static_cast<int>(5 * draw / badShare)]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            Point<Dim> p;
            for (int a = 0; a < Dim; ++a)
                p[a] = static_cast<double>(points[i * Dim + static_cast<std::size_t>(a)]);
            one.add(p);
        }
        many.addReturns(points.data(), count);
        expectEqual(many, one);
    }
    EXPECT_EQ(one.size() + one.skipped().total(), 1512u);
    EXPECT_EQ(bad > 0, badShare > 0);
}

TEST(RayBundle, ManyReturnsAreThoseOfOneByOne) {
    for (double badShare : {0.0, 0.001, 0.2}) {
        for (const RangeLimits& limits : {RangeLimits{}, RangeLimits{1, 30}}) {
            checkManyReturns<2, float>(badShare, limits);
            checkManyReturns<2, double>(badShare, limits);
            checkManyReturns<3, float>(badShare, limits);
            checkManyReturns<3, double>(badShare, limits);
        }
    }
}

TEST(RayBundle, CoordinatesAreInSinglePrecisionAsLongAsItHoldsThem) {
    const CellGeometry<3> g(0.1);
    const float floats[] = {0.1f, 0.2f, 0.3f, 1, 2, 3};
    const double doubles[] = {0.4, 0.5, 0.6};
    RayBundle<3> rays(g, {0.1, 0, 0});
    rays.add({0.5, 0.25, -1});
    rays.addReturns(floats, 2);
    EXPECT_TRUE(rays.singlePrecision());
    EXPECT_EQ(rays.ends<float>(1)[1], 0.2f);

    RayBundle<3> copy(g, {0, 0, 0});
    copy.add({0.7, 0, 0});
    EXPECT_FALSE(copy.singlePrecision());
    copy.restartLike(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) copy.place(i, rays, i);
    EXPECT_TRUE(copy.singlePrecision());

    rays.add({0.7, 0, 0}, RayEnd::noReturn);  // not a float
    EXPECT_FALSE(rays.singlePrecision());
    rays.addReturns(floats, 1);
    rays.addReturns(doubles, 1);
    ASSERT_EQ(rays.size(), 6u);
    const double x[] = {0.5, double{0.1f}, 1, 0.7, double{0.1f}, 0.4};
    const double z[] = {-1, double{0.3f}, 3, 0, double{0.3f}, 0.6};
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(rays.end(i).x(), x[i]);
        EXPECT_EQ(rays.ends<double>(2)[i], z[i]);
        EXPECT_EQ(rays.kind(i), i == 3 ? RayEnd::noReturn : RayEnd::hit);
    }
    ASSERT_EQ(copy.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(copy.end(i), rays.end(i));
    copy.restartLike(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) copy.place(i, rays, i);
    EXPECT_FALSE(copy.singlePrecision());
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(copy.end(i), rays.end(i));

    rays.restart({0, 0, 0});
    EXPECT_TRUE(rays.singlePrecision());
    rays.addReturns(doubles, 1);
    EXPECT_EQ(rays.end(0), Point<3>(0.4, 0.5, 0.6));
}

// GCC 12 takes double{float(x)} for x in the last of three such expressions in a row, where
// it finds them worth vectorising (-O2): whatever asks this must be tested per axis.
TEST(RayBundle, CoordinatesOfAnyAxisMayNeedDoubles) {
    const CellGeometry<3> g(0.1);
    for (int a = 0; a < 3; ++a) {
        Point<3> end(0.25, 0.5, 0.75);
        end[a] = 0.30000000000000004;
        RayBundle<3> one(g, {0, 0, 0}), many(g, {0, 0, 0});
        one.add(end);
        many.addReturns(end.data(), 1);
        for (const RayBundle<3>* rays : {&one, &many}) {
            EXPECT_FALSE(rays->singlePrecision()) << a;
            EXPECT_EQ(rays->end(0), end);
        }
    }
}

template <int Dim, typename Scalar>
void checkReturnsInThreads() {
    constexpr std::size_t kCount = 100001;
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> coordinate(-40, 40);
    const CellGeometry<Dim> g(0.1);
    std::vector<Scalar> points;
    for (std::size_t i = 0; i < kCount * Dim; ++i)
        points.push_back(static_cast<Scalar>(coordinate(random)));
    // All good; bad ones in the first, or in the last thread's share.
    for (const std::size_t bad : {kCount, std::size_t{5}, kCount - 1}) {
        std::vector<Scalar> some = points;
        if (bad < kCount) some[bad * Dim] = std::numeric_limits<Scalar>::quiet_NaN();
        RayBundle<Dim> one(g, Point<Dim>::Constant(0.03));
        one.add(Point<Dim>::Constant(0.5));
        RayBundle<Dim> many = one;
        one.addReturns(some.data(), kCount);
        EXPECT_EQ(one.size() + one.skipped().total(), kCount + 1);
        EXPECT_EQ(one.skipped().notFinite, bad < kCount ? 1u : 0u);
        many.addReturns(some.data(), kCount, 3);
        expectEqual(many, one);
    }
}

TEST(RayBundle, ManyReturnsInThreads) {
    checkReturnsInThreads<2, float>();
    checkReturnsInThreads<2, double>();
    checkReturnsInThreads<3, float>();
    checkReturnsInThreads<3, double>();
}

TEST(RayBundle, ManyReturnsAfterARayWithItsOwnOrigin) {
    const CellGeometry<3> g(0.1);
    RayBundle<3> one(g, {0, 0, 0}), many(g, {0, 0, 0});
    const float points[] = {1, 2, 3, 4, 5, 6};
    for (RayBundle<3>* rays : {&one, &many}) rays->add({0.5, 0, 0}, {7, 8, 9}, RayEnd::hit);
    one.add({0, 0, 0}, {1, 2, 3}, RayEnd::hit);
    one.add({0, 0, 0}, {4, 5, 6}, RayEnd::hit);
    many.addReturns(points, 2);
    expectEqual(many, one);
}

TEST(RayBundle, CopiesInAnotherOrder) {
    const CellGeometry<3> g(0.1), other(0.2);
    RayBundle<3> scan(g, Point<3>(1, 2, 3));
    for (int i = 0; i < 100; ++i)
        scan.add(Point<3>(i, -i, 0.5 * i), i % 3 == 0 ? RayEnd::noReturn : RayEnd::hit);
    RayBundle<3> copy(other, Point<3>::Zero());
    copy.add(Point<3>(9, 9, 9));
    copy.restartLike(scan);
    ASSERT_EQ(copy.size(), 100u);
    for (std::size_t i = 0; i < 100; ++i) copy.place(99 - i, scan, i);
    EXPECT_EQ(copy.geometry().resolution(), 0.1);
    EXPECT_EQ(copy.commonOrigin(), scan.commonOrigin());
    EXPECT_EQ(copy.lowest(), scan.lowest());
    EXPECT_EQ(copy.highest(), scan.highest());
    for (std::size_t i = 0; i < 100; ++i) {
        EXPECT_EQ(copy.end(99 - i), scan.end(i));
        EXPECT_EQ(copy.kind(99 - i), scan.kind(i));
    }
}

}  // namespace
}  // namespace superray
