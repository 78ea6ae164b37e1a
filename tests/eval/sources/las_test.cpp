// SPDX-License-Identifier: BSD-3-Clause
// LAS clouds, written by laspy (tests/data/formats): what is read, and what is refused.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>

#include <cstring>
#include <filesystem>

#include "eval/sources/format_samples.h"

namespace superray {
namespace {

using namespace test;

class LasCloud : public testing::Test {
 protected:
    static std::string whole(const std::string& folder = "las") {
        return readWholeFile(sample(folder + "/1000.500000.las"));
    }
    template <class T>
    static std::string changed(std::string bytes, std::size_t at, T value) {
        std::memcpy(&bytes.at(at), &value, sizeof value);
        return bytes;
    }
    Built built(const std::string& bytes, const std::string& name = "a.las") {
        ScanSourceOptions fixed;
        fixed.poses = PoseOrigin::fixed;
        return build(folder_.write(name, bytes), fixed);
    }
    std::string errorOf(const std::string& bytes, const std::string& name = "a.las") {
        return messageOf<InputError>([&] { built(bytes, name); });
    }

    TempFolder folder_;
};

TEST_F(LasCloud, isOneScanLikeOtherClouds) {
    const auto las = built(whole(), "A.LAS");
    EXPECT_EQ(las.scans, 1u);
    const auto pcd = built(readWholeFile(sample("pcd_ascii/1000.500000.pcd")), "a.pcd");
    EXPECT_EQ(las.digest, pcd.digest);
    EXPECT_EQ(built(whole("las_1_4")).digest, pcd.digest);
    EXPECT_EQ(built(whole() + std::string(16, '\0')).digest, pcd.digest);
    expectPart(messageOf<InputError>([&] { build(folder_ / "A.LAS"); }),
               "give a poses file (--poses FILE)");
}

TEST_F(LasCloud, deletedPointsAreLeftOut) {
    const auto start = static_cast<unsigned char>(whole()[96]);
    const std::string one = changed(whole(), start + 15, std::uint8_t{0x80});
    EXPECT_NE(built(one).digest, built(whole()).digest);
    // The bit means something else in the later formats.
    const std::string later = whole("las_1_4");
    const std::size_t first =
        static_cast<unsigned char>(later[96]) + 256u * static_cast<unsigned char>(later[97]);
    EXPECT_NE(built(changed(later, first + 15, std::uint8_t{0x04})).digest,
              built(later).digest);
    EXPECT_EQ(built(changed(later, first + 15, std::uint8_t{0x80})).digest,
              built(later).digest);
}

TEST_F(LasCloud, compressedOnesAreNamedWithTheWayOut) {
    expectPart(errorOf(whole(), "a.laz"), "las2las");
    expectPart(errorOf(changed(whole(), 104, std::uint8_t{0x81})), "is compressed (LAZ)");
    std::filesystem::create_directory(folder_ / "laz");
    folder_.write("laz/1.laz", whole());
    expectPart(messageOf<InputError>([&] { build(folder_ / "laz"); }), "pdal translate");
}

TEST_F(LasCloud, coordinatesOfACountryAreRefused) {
    std::string utm = changed(whole(), 155, 500000.0);  // the offset of x
    utm = changed(changed(utm, 179, 600000.0), 187, 400000.0);
    const auto message = errorOf(utm);
    expectPart(message, "has points at x 49999");
    expectPart(message, "las2las -translate_xyz");
}

TEST_F(LasCloud, headersThatCannotBeAreRefused) {
    expectPart(errorOf("LASX" + whole().substr(4)), "does not begin with LASF");
    expectPart(errorOf(changed(whole(), 25, std::uint8_t{5})), "version 1.5");
    expectPart(errorOf(changed(whole(), 25, std::uint8_t{4})), "do not fit");
    expectPart(errorOf(changed(whole(), 96, std::uint32_t{1} << 30)), "do not fit its size");
    expectPart(errorOf(changed(whole(), 104, std::uint8_t{11})), "point format 11");
    expectPart(errorOf(changed(whole(), 105, std::uint16_t{20})), "points of 20 bytes");
    expectPart(errorOf(changed(whole(), 107, std::uint32_t{81})), "ends early");
    expectPart(errorOf(changed(whole(), 107, std::uint32_t{79})), "other data follow");
    expectPart(errorOf(changed(whole("las_1_4"), 107, std::uint32_t{5})), "counts");
    expectPart(errorOf(changed(whole("las_1_4"), 247, std::uint64_t{1} << 62)), "ends early");
    expectPart(errorOf(changed(whole(), 131, -0.001)), "a scale must be > 0");
    expectPart(errorOf(changed(whole(), 131, 0.001)), "its header says");
    expectPart(errorOf(changed(whole(), 179, -100.0)), "'pdal translate' writes a new header");
    expectPart(errorOf(whole().substr(0, 226)), "ends early");
}

}  // namespace
}  // namespace superray
