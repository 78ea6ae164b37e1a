// SPDX-License-Identifier: BSD-3-Clause
// Digests of maps of generated scans, as recorded: any processor and any compiler
// must make the same maps, bit for bit. What they depend on is exact everywhere:
// random numbers are made here, and no function of the mathematics library takes
// part but the logarithms of the sensor model.

#include <superray/core/reference_mapper.h>
#include <superray/core/scan_integrator.h>
#include <superray/storage/block_grid.h>
#include <superray/storage/octree.h>
#include <superray/storage/quadtree.h>

#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <type_traits>
#include <vector>

#include "core/ray_generators.h"

namespace superray {
namespace {

constexpr int kScans = 2 * std::size(test::kScenes);
constexpr int kRays = 800;
constexpr Method kMethods[] = {Method::perRay, Method::superRays, Method::culling, Method::full,
                               Method::automatic};

/// A scan of every scene, in double and in single precision, from one place each.
template <int Dim>
std::vector<RayBundle<Dim>> scans(const CellGeometry<Dim>& geometry) {
    std::vector<RayBundle<Dim>> all;
    test::Random random(20240229);
    for (test::Scene scene : test::kScenes) {
        all.push_back(test::makeScan<Dim>(scene, random, geometry, kRays));
        all.push_back(test::rounded(all.back()));
    }
    return all;
}

template <int Dim, typename Map>
std::string digestOf(const std::vector<RayBundle<Dim>>& scans, const IntegratorOptions& options,
                     Map map) {
    const SensorModel model(SensorProbabilities::defaultsOf(options.policy));
    ScanIntegrator<Dim> integrator;
    for (const RayBundle<Dim>& scan : scans) {
        if (ScanIntegrator<Dim>::needsExactCounts(options, model, &map))
            map.OccupancyMap<Dim>::apply(countCells(scan), model, options.policy);
        else
            map.apply(integrator.integrate(scan, model, options, &map), model, options.policy);
    }
    return contentDigest<Dim>(map);
}

/// Every method, storage and number of threads makes the map of the table's row.
template <int Dim>
void expectDigest(double resolution, UpdatePolicy policy, const std::string& recorded) {
    using Tree = std::conditional_t<Dim == 2, Quadtree, Octree>;
    const CellGeometry<Dim> geometry(resolution);
    const auto all = scans(geometry);
    ASSERT_EQ(all.size(), std::size_t{kScans});
    IntegratorOptions options;
    options.policy = policy;
    options.method = Method::reference;
    const std::string digest = digestOf(all, options, BlockGrid<Dim>(geometry));
    std::cout << "digest " << Dim << "D " << resolution << " m " << toString(policy) << " "
              << digest << "\n";
    EXPECT_EQ(digest, recorded);
    for (Method method : kMethods)
        for (unsigned threads : {1u, 3u}) {
            options.method = method;
            options.threads = threads;
            EXPECT_EQ(digestOf(all, options, BlockGrid<Dim>(geometry)), recorded)
                << toString(method) << ", grid, threads: " << threads;
            EXPECT_EQ(digestOf(all, options, Tree(geometry)), recorded)
                << toString(method) << ", tree, threads: " << threads;
        }
}

constexpr auto kEveryRay = UpdatePolicy::everyRay, kOncePerScan = UpdatePolicy::oncePerScan,
               kNetEvidence = UpdatePolicy::netEvidence;

TEST(DigestTable, MapsIn2D) {
    expectDigest<2>(0.05, kEveryRay, "9cb262ecccb435090ce404e7a4526aa9");
    expectDigest<2>(0.05, kOncePerScan, "c6c949762c9a9eee149433e6a18fb50e");
    expectDigest<2>(0.05, kNetEvidence, "401b204daf53a2bbf26f04bfc73c5475");
    expectDigest<2>(0.3, kEveryRay, "8c4be50e6aabe4e4f109df7ced537ddb");
    expectDigest<2>(0.3, kOncePerScan, "f47d43f1700c45a29356fd58603bdac3");
    expectDigest<2>(0.3, kNetEvidence, "ef2ceeeba268d5c083e44bb5d2a2683f");
}

TEST(DigestTable, MapsIn3D) {
    expectDigest<3>(0.05, kEveryRay, "4e4402cc7323c8cdda1581d873271274");
    expectDigest<3>(0.05, kOncePerScan, "6bbab1b1b85f8fc2d62520a397ed0be6");
    expectDigest<3>(0.05, kNetEvidence, "34a9de5b0cb78bdca0ef2b55c350faec");
    expectDigest<3>(0.3, kEveryRay, "e8950d8ec3b9f57f58176c1ef33ff186");
    expectDigest<3>(0.3, kOncePerScan, "6ca05a8033a36c45f5268656e2766b2e");
    expectDigest<3>(0.3, kNetEvidence, "7afa5a04385a476ef3fe595a0a2279da");
}

}  // namespace
}  // namespace superray
