// SPDX-License-Identifier: BSD-3-Clause
// Small sets of rays on and just beside the borders, edges and corners of cells: every method
// against the oracle. Random rays come so close to a border too seldom to find anything.
//
// The environment variable SUPERRAY_LATTICE_SETS asks for more sets than a usual run has.

#include <cmath>
#include <cstdlib>

#include "core/dims.h"
#include "core/lattice_map.h"
#include "core/ray_generators.h"
#include "core/test_map.h"

namespace superray {
namespace {

using namespace test;

int setsToTry() {
    const char* asked = std::getenv("SUPERRAY_LATTICE_SETS");
    return asked != nullptr ? std::atoi(asked) : 6000;
}

/// A coordinate on a cell border, a unit beside it, a rounding error beside it, or somewhere.
double latticeCoordinate(Random& random, int reach) {
    const double border = test::integer(random, -reach, reach);
    switch (test::integer(random, 0, 9)) {
        case 0:
        case 1:
            return border;
        case 2:
            return std::nextafter(border, 1e9);
        case 3:
            return std::nextafter(border, -1e9);
        case 4:
            return border + 0x1p-30 * test::integer(random, -2, 2);
        case 5:
            return border + 0x1p-31 * test::integer(random, -3, 3);
        case 6:
            return border + 0.5;
        case 7:
            return border + 1e-15 * test::integer(random, -9, 9);
        case 8:
            return border +
                   std::ldexp(test::uniform(random, -1, 1), test::integer(random, -40, -1));
        default:
            return border + test::uniform(random, 0, 1);
    }
}

/// A set of rays from one origin, which often end in few cells, and differ by little.
template <int Dim>
RayBundle<Dim> latticeRays(Random& random, double resolution) {
    const CellGeometry<Dim> g(resolution);
    constexpr int kReaches[] = {1, 1, 2, 2, 3, 5, 9, 40};
    const int reach = kReaches[test::integer(random, 0, 7)];
    Point<Dim> origin, last;
    for (int a = 0; a < Dim; ++a) {
        origin[a] = latticeCoordinate(random, 2) * resolution;
        last[a] = latticeCoordinate(random, reach) * resolution;
    }
    RayBundle<Dim> rays(g, origin);
    const int count = test::integer(random, 2, 7);
    for (int i = 0; i < count; ++i) {
        // Most rays are the last one, with some axes drawn again.
        const int again = test::integer(random, 0, (1 << Dim) - 1);
        for (int a = 0; a < Dim; ++a)
            if (again >> a & 1) last[a] = latticeCoordinate(random, reach) * resolution;
        rays.add(last, test::integer(random, 0, 4) == 0 ? RayEnd::noReturn : RayEnd::hit);
    }
    return rays;
}

template <typename T>
class Lattice : public ::testing::Test {};
TYPED_TEST_SUITE(Lattice, test::Dims);

TYPED_TEST(Lattice, AllMethodsUpdateTheMapAsTheOracleDoes) {
    constexpr int Dim = TypeParam::value;
    constexpr std::uint64_t kOneIn[] = {1, 2, 8, 60};
    Random random(7);
    ScanIntegrator<Dim> integrator;
    const int sets = setsToTry();
    ASSERT_GT(sets, 0);
    std::uint64_t comparisons = 0, merged = 0, culled = 0;
    for (int set = 0; set < sets; ++set) {
        const double resolution = set % 3 == 0 ? 0.1 : set % 3 == 1 ? 1.0 : 0.3;
        const RayBundle<Dim> exact = latticeRays<Dim>(random, resolution);
        const RayBundle<Dim> rays = set % 4 == 0 ? test::rounded(exact) : exact;
        const CellCountMap<Dim> expected = countCells(rays);
        const HoledMap<Dim> map(random(), kOneIn[set % 4]);
        const std::string different =
            firstDifferentRun<Dim>(rays, expected, map, set % 64 == 0 ? 2 : 1, integrator,
                                   [&](Method method, const ScanStatistics& s) {
                                       ++comparisons;
                                       if (method == Method::superRays)
                                           merged += s.rays - s.superRays;
                                       culled += s.raysCulled;
                                   });
        ASSERT_EQ(different, "") << "set " << set;
    }
    EXPECT_EQ(comparisons, static_cast<std::uint64_t>(sets) * std::size(kFastMethods) *
                               std::size(kUpdatePolicies));
    EXPECT_GT(merged, static_cast<std::uint64_t>(sets) / 20);
    EXPECT_GT(culled, static_cast<std::uint64_t>(sets) / 2);
}

}  // namespace
}  // namespace superray
