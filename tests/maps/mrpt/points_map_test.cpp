// SPDX-License-Identifier: BSD-3-Clause
// The occupancy maps that are points maps.

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayPointsMap.h>

#include <map>

#include <cmath>
#include <cstring>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

template <class Points>
constexpr int kDim = std::is_same_v<Points, CSuperRayPointsMap2D> ? 2 : 3;

CPose3D poseOf(unsigned i) {
    // Some come back, so that cells are freed again.
    return {0.8 * (i % 4), -0.3 * (i % 3), 0.2, 0.3 * i, 0, 0};
}

template <class Points>
void insert(Points& map, unsigned first, unsigned count) {
    for (unsigned i = first; i < first + count; ++i)
        ASSERT_TRUE(map.insertObservation(*test::randomCloud(400, i), poseOf(i)));
}

/// Points by the cell that they are in.
template <int Dim>
std::map<Cell<Dim>, std::array<float, 3>> pointsByCell(const CSuperRayPointsMap<Dim>& map) {
    std::map<Cell<Dim>, std::array<float, 3>> points;
    for (std::size_t i = 0; i < map.size(); ++i) {
        std::array<float, 3> p{};
        map.getPoint(i, p[0], p[1], p[2]);
        Point<Dim> position;
        for (int a = 0; a < Dim; ++a) position[a] = p[static_cast<std::size_t>(a)];
        const auto cell = map.occupancy().storage().geometry().cellOf(position);
        EXPECT_TRUE(points.emplace(cell, p).second) << "two points in a cell";
        EXPECT_TRUE(Dim == 3 || p[2] == 0);
    }
    return points;
}

template <int Dim>
void expectPointsAreTheOccupiedCells(const CSuperRayPointsMap<Dim>& map) {
    const float occupied = map.occupancy().sensorModel().occupied();
    EXPECT_EQ(map.size(), map.occupancy().cellTotals().occupied);
    for (const auto& [cell, point] : pointsByCell(map)) {
        const auto value = map.occupancy().storage().logOdds(cell);
        ASSERT_TRUE(value);
        EXPECT_GE(*value, occupied);
    }
}

template <class Points>
class PointsMaps : public ::testing::Test {};
using Classes = ::testing::Types<CSuperRayPointsMap2D, CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(PointsMaps, Classes);

TYPED_TEST(PointsMaps, PointsFollowTheCellsAndTheCellsAreThoseOfTheGridMap) {
    TypeParam map(0.2);
    typename TypeParam::GridMap alone(0.2);
    EXPECT_TRUE(map.isEmpty());
    auto paper = map.occupancy().options();  // a rule that frees many cells
    paper.insertion.setPolicy(UpdatePolicy::everyRay);
    map.setOptions(paper);
    alone.setOptions(paper);
    std::size_t shrunk = 0;
    for (unsigned i = 0; i < 15; ++i) {
        const auto before = map.size();
        insert(map, i, 1);
        insert(alone, i, 1);
        ASSERT_EQ(map.occupancy().digest(), alone.digest());
        expectPointsAreTheOccupiedCells(map);
        shrunk += map.size() < before ? 1 : 0;
    }
    EXPECT_GT(map.size(), 200u);
    EXPECT_TRUE(kDim<TypeParam> == 3 || shrunk > 0) << "no cell was freed";
    EXPECT_FALSE(map.isEmpty());

    // Other thresholds make other cells occupied, also such that were only missed.
    for (const double threshold : {0.8, 0.3, 0.5}) {
        auto options = map.occupancy().options();
        options.insertion.occupancyThres = threshold;
        map.setOptions(options);
        expectPointsAreTheOccupiedCells(map);
        insert(map, 20, 3);
        expectPointsAreTheOccupiedCells(map);
    }
    auto exact = map.occupancy().options();
    exact.insertion.probMiss = 0.4999;  // a model that needs exact counts
    map.setOptions(exact);
    insert(map, 30, 3);
    expectPointsAreTheOccupiedCells(map);
    // Points that somebody else took away come back.
    map.setSize(3);
    insert(map, 33, 1);
    expectPointsAreTheOccupiedCells(map);
    map.clear();
    EXPECT_EQ(map.size(), 0u);
    EXPECT_TRUE(map.isEmpty());
    insert(map, 0, 2);
    expectPointsAreTheOccupiedCells(map);
}

TYPED_TEST(PointsMaps, APointIsTheMeanOfTheEndsInItsCell) {
    constexpr int Dim = kDim<TypeParam>;
    // Cells so large that rays seldom free what others hit.
    TypeParam map(2.0);
    std::map<Cell<Dim>, std::pair<Eigen::Vector3d, int>> ends;
    for (unsigned i = 0; i < 4; ++i) {
        auto scan = test::randomCloud(100, i, 3, 9);
        const CPose3D pose = poseOf(i);
        ASSERT_TRUE(map.insertObservation(*scan, pose));
        const auto points = pointsByCell(map);
        for (std::size_t p = 0; p < scan->pointcloud->size(); ++p) {
            float x = 0, y = 0, z = 0;
            scan->pointcloud->getPoint(p, x, y, z);
            Eigen::Vector3d end;
            (pose + scan->sensorPose).composePoint(x, y, z, end[0], end[1], end[2]);
            if (Dim == 2) end[2] = 0;
            const auto cell =
                map.occupancy().storage().geometry().cellOf(end.head<Dim>().eval());
            auto& [sum, count] =
                ends.try_emplace(cell, Eigen::Vector3d::Zero(), 0).first->second;
            sum += end;
            ++count;
        }
        // Only since the cell is occupied.
        for (auto e = ends.begin(); e != ends.end();)
            e = points.count(e->first) ? std::next(e) : ends.erase(e);
    }
    std::size_t several = 0;
    const auto points = pointsByCell(map);
    ASSERT_EQ(points.size(), ends.size());
    for (const auto& [cell, point] : points) {
        const auto& [sum, count] = ends.at(cell);
        several += count > 1 ? 1 : 0;
        for (int a = 0; a < 3; ++a)
            EXPECT_NEAR(point[static_cast<std::size_t>(a)], sum[a] / count, 1e-4);
    }
    EXPECT_GT(points.size(), 20u);
    EXPECT_GT(several, 10u);
}

template <class Points>
void expectEqualMaps(const Points& a, const Points& b) {
    EXPECT_EQ(a.occupancy().digest(), b.occupancy().digest());
    EXPECT_EQ(a.occupancy().optionsAsIniText(), b.occupancy().optionsAsIniText());
    EXPECT_EQ(pointsByCell(a), pointsByCell(b));
}

TYPED_TEST(PointsMaps, CopiesAndStreamsKeepEverything) {
    TypeParam map(0.2);
    auto options = map.occupancy().options();
    options.insertion.probHit = 0.8;
    options.creation.enableSaveAs3DObject = false;
    map.setOptions(options);
    insert(map, 0, 5);

    TypeParam copy(map), assigned(0.7);
    insert(assigned, 3, 1);
    assigned = map;
    mrpt::io::CMemoryStream stream;
    mrpt::serialization::archiveFrom(stream) << map;
    stream.Seek(0);
    const auto read = std::dynamic_pointer_cast<TypeParam>(
        mrpt::serialization::archiveFrom(stream).ReadObject());
    ASSERT_TRUE(read);
    EXPECT_FALSE(read->genericMapParams.enableSaveAs3DObject);
    for (TypeParam* other : {&copy, &assigned, read.get()}) {
        expectEqualMaps(*other, map);
        TypeParam continued(map);
        insert(*other, 5, 3);
        insert(continued, 5, 3);
        expectEqualMaps(*other, continued);
    }
    // Copies through the base class, too, where MRPT asks; but not from other points.
    mrpt::maps::CPointsMap& base = assigned;
    base = static_cast<const mrpt::maps::CPointsMap&>(map);
    const auto cloud = test::randomCloud(10, 1)->pointcloud;
    if (kAssignmentAsksThePointsMap) {
        expectEqualMaps(assigned, map);
        EXPECT_THROW(base = *cloud, std::invalid_argument);
        expectEqualMaps(assigned, map);
    } else {
        EXPECT_EQ(assigned.size(), map.size());
        EXPECT_TRUE(assigned.occupancy().isEmpty()) << "bare points";
        EXPECT_NO_THROW(base = *cloud);
        EXPECT_EQ(assigned.size(), 10u);
    }

    // A stream that breaks off, or with a point where no cell is occupied.
    std::vector<std::uint8_t> bytes;
    mrpt::serialization::ObjectToOctetVector(&map, bytes);
    for (const std::size_t cut : {bytes.size() / 2, bytes.size() - 20}) {
        std::vector<std::uint8_t> broken(bytes.begin(),
                                         bytes.begin() + static_cast<std::ptrdiff_t>(cut));
        mrpt::serialization::CSerializable::Ptr object;
        EXPECT_ANY_THROW(mrpt::serialization::OctetVectorToObject(broken, object));
    }
}

template <class Points>
std::shared_ptr<Points> readBack(const std::vector<std::uint8_t>& bytes) {
    mrpt::serialization::CSerializable::Ptr object;
    mrpt::serialization::OctetVectorToObject(bytes, object);
    auto map = std::dynamic_pointer_cast<Points>(object);
    if (!map) throw std::runtime_error("another class");
    return map;
}

TYPED_TEST(PointsMaps, NoChangedBitOfAStreamIsAccepted) {
    TypeParam map(0.5);
    ASSERT_TRUE(map.insertObservation(*test::randomCloud(12, 1), CPose3D()));
    ASSERT_GT(map.size(), 3u);
    std::vector<std::uint8_t> bytes;
    mrpt::serialization::ObjectToOctetVector(&map, bytes);
    // MRPT looks up classes without their namespaces.
    const std::string text(bytes.begin(), bytes.end()), name = "superray::";
    std::vector<bool> inNamespace(bytes.size(), false);
    for (auto at = text.find(name); at != std::string::npos; at = text.find(name, at + 1))
        std::fill_n(inNamespace.begin() + static_cast<std::ptrdiff_t>(at), name.size(), true);
    std::size_t refused = 0, same = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto changed = bytes;
        changed[bit / 8] = static_cast<std::uint8_t>(changed[bit / 8] ^ (1u << bit % 8));
        std::shared_ptr<TypeParam> read;
        try {
            read = readBack<TypeParam>(changed);
        } catch (const std::exception&) {
            ++refused;
            continue;
        }
        ++same;
        ASSERT_TRUE(inNamespace[bit / 8]) << bit;
        ASSERT_EQ(read->occupancy().digest(), map.occupancy().digest()) << bit;
        ASSERT_EQ(pointsByCell(*read), pointsByCell(map)) << bit;
    }
    const auto letters = std::count(inNamespace.begin(), inNamespace.end(), true);
    EXPECT_GE(refused + 8 * static_cast<std::size_t>(letters), 8 * bytes.size())
        << same << " accepted with the same contents";
    for (std::size_t size = 0; size + 1 < bytes.size(); ++size) {
        const std::vector<std::uint8_t> cut(bytes.begin(),
                                            bytes.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_ANY_THROW(readBack<TypeParam>(cut)) << size;
    }
}

// Version 0 has no checksum behind the points.
TYPED_TEST(PointsMaps, StreamsOfVersion0AreReadAndTheirPointsChecked) {
    TypeParam map(0.5);
    insert(map, 0, 2);
    std::vector<std::uint8_t> bytes;
    mrpt::serialization::ObjectToOctetVector(&map, bytes);
    const std::size_t version = 1 + (bytes[0] & 0x7Fu);
    ASSERT_EQ(bytes[version], 1);
    bytes[version] = 0;
    constexpr std::ptrdiff_t kChecksum = 4, kEndMark = 1;
    bytes.erase(bytes.end() - kChecksum - kEndMark, bytes.end() - kEndMark);
    expectEqualMaps(*readBack<TypeParam>(bytes), map);

    // The last coordinate of the last point: far away, and not a number.
    for (const float wrong : {1e4f, -1e30f, std::nanf("")}) {
        auto changed = bytes;
        std::memcpy(&changed[bytes.size() - kEndMark - sizeof wrong], &wrong, sizeof wrong);
        EXPECT_ANY_THROW(readBack<TypeParam>(changed)) << wrong;
    }
}

TYPED_TEST(PointsMaps, FromAnIniFileAsTheOnlyPointsMap) {
    const test::TempFolder folder;
    typename TypeParam::GridMap saved(0.25);
    insert(saved, 0, 4);
    saved.saveToFile(folder.file("saved.srmap"));
    const std::string name = "superRayPointsMap" + std::to_string(kDim<TypeParam>) + "D";
    const mrpt::config::CConfigFileMemory file(
        "[m]\n" + name + "_count = 1\n[m_" + name + "_00_creationOpts]\nload_from = " +
        folder.file("saved.srmap") + "\n[m_" + name + "_00_insertOpts]\nmaxrange = 7\n");
    mrpt::maps::TSetOfMetricMapInitializers definitions;
    definitions.loadFromConfigFile(file, "m");
    mrpt::maps::CMultiMetricMap maps;
    maps.setListOfMaps(definitions);
    const auto points = maps.mapByClass<mrpt::maps::CPointsMap>();
    ASSERT_TRUE(points);
    auto& map = dynamic_cast<TypeParam&>(*points);
    EXPECT_EQ(map.occupancy().digest(), saved.digest());
    EXPECT_EQ(map.occupancy().insertionOptions.maxrange, 7);
    expectPointsAreTheOccupiedCells(map);
    const auto geometry = saved.storage().geometry();
    for (const auto& [cell, point] : pointsByCell(map))
        EXPECT_FLOAT_EQ(point[0], static_cast<float>(geometry.center(cell)[0]));

    // What a grid map alone would say and write.
    const auto scan = test::randomCloud(200, 77);
    EXPECT_TRUE(map.canComputeObservationLikelihood(*scan));
    EXPECT_EQ(map.computeObservationLikelihood(*scan, poseOf(1)),
              map.occupancy().computeObservationLikelihood(*scan, poseOf(1)));
    EXPECT_NE(map.computeObservationLikelihood(*scan, poseOf(1)), 0);
    mrpt::opengl::CSetOfObjects objects;
    map.getVisualizationInto(objects);
    EXPECT_EQ(objects.getByClass<mrpt::opengl::COctoMapVoxels>()->getVoxelCount(0), map.size());
    map.saveMetricMapRepresentationToFile(folder.file("written"));
    EXPECT_EQ(test::interfaceOf(*loadMap(folder.file("written.srmap"))).digest(),
              saved.digest());
    EXPECT_CONTAINS(map.asString(), std::to_string(map.size()) + " occupied cells");

    // Pairs with its own points, moved a little.
    mrpt::maps::CSimplePointsMap moved;
    const CPose3D shift(0.05, 0.03, 0, 0, 0, 0);
    moved.changeCoordinatesReference(map, shift);
    mrpt::tfest::TMatchingPairList pairs;
    mrpt::maps::TMatchingParams params;
    params.maxDistForCorrespondence = 0.1f;
    mrpt::maps::TMatchingExtraResults results;
    map.determineMatching2D(&moved, mrpt::poses::CPose2D(), pairs, params, results);
    EXPECT_GT(results.correspondencesRatio, 0.8f);
    map.loadFromFile(folder.file("written.srmap"));
    expectPointsAreTheOccupiedCells(map);
}

}  // namespace
}  // namespace superray
