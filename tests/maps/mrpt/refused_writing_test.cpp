// SPDX-License-Identifier: BSD-3-Clause
// What cannot be read again, or has no name, is not written.

#include <mrpt/serialization/CArchive.h>
#include <superray/maps/CSuperRayPointsMap.h>

#include <filesystem>
#include <functional>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;

template <class Points>
class MovedPoints : public ::testing::Test {
 protected:
    static constexpr bool kIs3D = std::is_same_v<Points, CSuperRayPointsMap3D>;

    MovedPoints() {
        for (unsigned i = 0; i < 3; ++i)
            map_.insertObservation(*test::randomCloud(200, i), CPose3D(900, -70, 0, 0, 0, 0));
    }
    static std::vector<std::uint8_t> streamOf(const Points& map) {
        std::vector<std::uint8_t> bytes;
        mrpt::serialization::ObjectToOctetVector(&map, bytes);
        return bytes;
    }
    Points map_{0.2};
};
using Classes = ::testing::Types<CSuperRayPointsMap2D, CSuperRayPointsMap3D>;
TYPED_TEST_SUITE(MovedPoints, Classes);

TYPED_TEST(MovedPoints, AreNotWrittenToStreamsThatCouldNotBeRead) {
    const std::function<void(TypeParam&)> moves[] = {
        [](TypeParam& map) { map.changeCoordinatesReference(CPose3D(0.5, 0, 0, 0.3, 0, 0)); },
        [](TypeParam& map) { map.setPoint(1, 100, 100, 100); },
        [](TypeParam& map) { map.setPoint(map.size() - 1, std::nanf(""), 0, 0); }};
    for (const auto& move : moves) {
        TypeParam moved(this->map_);
        move(moved);
        const std::string message = test::messageOf([&] { this->streamOf(moved); });
        EXPECT_CONTAINS(message, "point ");
        EXPECT_CONTAINS(message, "must lie in its cell");
        EXPECT_CONTAINS(message, "write occupancy()");
    }
    TypeParam fewer(this->map_);
    fewer.setSize(3);
    EXPECT_CONTAINS(test::messageOf([&] { this->streamOf(fewer); }), "3 points for ");
}

TYPED_TEST(MovedPoints, WhatStaysInItsCellIsWritten) {
    TypeParam map(this->map_);
    for (int step = 0; step < 2; ++step) {
        mrpt::serialization::CSerializable::Ptr read;
        mrpt::serialization::OctetVectorToObject(this->streamOf(map), read);
        const auto& back = dynamic_cast<const TypeParam&>(*read);
        ASSERT_EQ(back.size(), map.size());
        EXPECT_EQ(back.getPointsBufferRef_x(), map.getPointsBufferRef_x());
        // Back in the middle of its cell.
        float x = 0, y = 0, z = 0;
        map.getPoint(0, x, y, z);
        Point<3> p(double{x}, double{y}, double{z});
        for (int a = 0; a < 3; ++a) p[a] = 0.2 * (std::floor(p[a] / 0.2) + 0.5);
        const Eigen::Vector3f middle = p.template cast<float>();
        map.setPoint(0, middle.x(), middle.y(), this->kIs3D ? middle.z() : 0.0f);
    }
}

TEST(RefusedWriting, APrefixWithoutAFileNameSaysSo) {
    const test::TempFolder folder;
    for (const auto& className : mapClassNames()) {
        const auto map = createMap(className);
        for (const std::string& prefix : {std::string(), folder.file("")}) {
            const std::string message =
                test::messageOf([&] { map->saveMetricMapRepresentationToFile(prefix); });
            EXPECT_CONTAINS(message, "prefix \"" + prefix + "\"");
            EXPECT_CONTAINS(message, "has no file name");
        }
        EXPECT_TRUE(std::filesystem::is_empty(folder.file(""))) << className;
    }
}

}  // namespace
}  // namespace superray
