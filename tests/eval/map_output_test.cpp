// SPDX-License-Identifier: BSD-3-Clause
// What is written about maps and from them: info, exports, pictures.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_info.h>
#include <superray/eval/map_output.h>
#include <superray/eval/output_paths.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>

#include <set>

#include "eval/temp_folder.h"

namespace superray {
namespace {

using test::messageOf;
using test::readWholeFile;
using test::TempFolder;

/// Three walls of a room, hit once, seen from its middle.
CSuperRayGridMap3D makeRoom() {
    CSuperRayGridMap3D map(0.1);
    RayBundle<3> rays(CellGeometry<3>(0.1), {0.05, 0.05, 1.05});
    for (double a = -2; a <= 2; a += 0.05)
        for (double z = 0.05; z <= 2; z += 0.05) {
            rays.add({a, 2.05, z});
            rays.add({-2.05, a, z});
            rays.add({a, 2 * z - 2, 0.0});
        }
    map.insertRays(rays);
    return map;
}

TEST(Json, escapesStrings) {
    EXPECT_EQ(jsonString("plain"), "\"plain\"");
    EXPECT_EQ(jsonString("a\"b\\c\n\x01"), "\"a\\\"b\\\\c\\u000a\\u0001\"");
    EXPECT_EQ(jsonString("r\xc3\xa9sum\xc3\xa9 \xf0\x9f\x97\xba"),
              "\"r\xc3\xa9sum\xc3\xa9 \xf0\x9f\x97\xba\"");
    EXPECT_EQ(jsonString("\xff\xc3(\xed\xa0\x80\xc0\xaf\xe2\x82"),
              "\"\\ufffd\\ufffd(\\ufffd\\ufffd\\ufffd\\ufffd\\ufffd\\ufffd\\ufffd\"");
}

TEST(Info, tellsTheNumbersOfTheMap) {
    const auto map = makeRoom();
    const auto totals = map.cellTotals();
    ASSERT_GT(totals.occupied, 1000u);
    const auto json = infoAsJson(map, "a\"b.srmap");
    EXPECT_NE(json.find("\"file\": \"a\\\"b.srmap\""), std::string::npos) << json;
    EXPECT_NE(json.find("\"class\": \"CSuperRayGridMap3D\""), std::string::npos);
    EXPECT_NE(json.find("\"resolution\": 0.1,"), std::string::npos);
    EXPECT_NE(json.find("\"known\": " + std::to_string(totals.known)), std::string::npos);
    EXPECT_NE(json.find("\"digest\": \"" + map.digest() + "\""), std::string::npos);
    EXPECT_NE(json.find("\"probHit\": \"0.9\""), std::string::npos);
    const auto text = infoAsText(map, "a.srmap");
    EXPECT_NE(text.find(map.digest()), std::string::npos);
    EXPECT_NE(text.find("probHit"), std::string::npos);
    EXPECT_NE(infoAsJson(CSuperRayGridMap2D(), "b").find("\"bounds\": null"),
              std::string::npos);
    EXPECT_NE(infoAsText(CSuperRayGridMap2D(), "b").find("the map is empty"),
              std::string::npos);
}

TEST(Export, writesEveryFormatAndNothingElse) {
    TempFolder folder;
    const auto map = makeRoom();
    std::set<std::string> expected;
    for (const char* name : {"a.ot", "a.bt", "a.ply", "a.3Dscene", "a.png"}) {
        exportMap(map, folder / name);
        expected.insert(name);
        EXPECT_GT(std::filesystem::file_size(folder / name), 100u) << name;
    }
    EXPECT_EQ(readWholeFile(folder / "a.png").substr(1, 3), "PNG");
    EXPECT_EQ(readWholeFile(folder / "a.ply").substr(0, 3), "ply");
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
        found.insert(entry.path().filename().string());
    EXPECT_EQ(found, expected);
}

TEST(Export, anErrorLeavesTheOldFile) {
    TempFolder folder;
    const CSuperRayGridMap2D plan(0.1);
    for (const char* name : {"a.ot", "a.bt"}) {
        folder.write(name, "old");
        EXPECT_THROW(exportMap(plan, folder / name), InputError) << name;
        EXPECT_EQ(readWholeFile(folder / name), "old");
    }
    folder.write("a.png", "old");
    EXPECT_THROW(exportMap(CSuperRayGridMap3D(0.1), folder / "a.png"), InputError);
    EXPECT_EQ(readWholeFile(folder / "a.png"), "old");
    EXPECT_THROW(exportMap(plan, folder / "a.jpg"), InputError);
    EXPECT_THROW(exportMap(plan, folder / "absent/a.ply"), InputError);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 3);
}

TEST(OutputPath, isCheckedBeforehand) {
    TempFolder folder;
    const auto errorOf = [&](const std::string& path) {
        return messageOf<InputError>([&] { checkOutputPath(path, {".srmap"}); });
    };
    EXPECT_EQ(errorOf(folder / "a.srmap"), "no exception");
    EXPECT_EQ(errorOf("a.srmap"), "no exception");
    EXPECT_NE(errorOf(folder / "a.map").find("must end in .srmap"), std::string::npos);
    EXPECT_NE(errorOf(folder / "absent/a.srmap").find("does not exist"), std::string::npos);
    std::filesystem::create_directory(folder / "b.srmap");
    EXPECT_NE(errorOf(folder / "b.srmap").find("is a folder"), std::string::npos);
}

TEST(Picture, showsTheMapInColour) {
    const auto map = makeRoom();
    PictureOptions options;
    options.width = 600;
    options.height = 400;
    const auto picture = drawMap(map.storage(), map.sensorModel(), options);
    ASSERT_EQ(picture.getWidth(), 600u);
    ASSERT_EQ(picture.getHeight(), 400u);
    // The background is grey; the map must fill a good part of both views.
    int coloured[2] = {0, 0};
    for (unsigned y = 0; y < 400; ++y)
        for (unsigned x = 0; x < 600; ++x) {
            const auto channel = [&](int c) {
                return static_cast<int>(
                    *picture.ptr<std::uint8_t>(x, y, static_cast<unsigned>(c)));
            };
            const int spread = std::max({channel(0), channel(1), channel(2)}) -
                               std::min({channel(0), channel(1), channel(2)});
            coloured[x < 400 ? 0 : 1] += spread > 30;
        }
    EXPECT_GT(coloured[0], 400 * 400 / 8);
    EXPECT_GT(coloured[1], 200 * 400 / 8);
}

TEST(Picture, refusesWhatCannotBeDrawn) {
    const auto map = makeRoom();
    const auto draw = [&](const PictureOptions& options) {
        return messageOf<std::invalid_argument>(
            [&] { drawMap(map.storage(), map.sensorModel(), options); });
    };
    PictureOptions options;
    options.cutAbove = -5;
    EXPECT_NE(draw(options).find("nothing to draw"), std::string::npos);
    for (const int side : {0, -5, 199, 10001}) {
        options = {};
        options.width = side;
        EXPECT_NE(draw(options).find("must be in [200, 10000]"), std::string::npos);
        options = {};
        options.height = side;
        EXPECT_NE(draw(options).find("must be in [200, 10000]"), std::string::npos);
    }
}

TEST(Picture, ofASingleCellIsDrawn) {
    CSuperRayGridMap3D map(0.1);
    RayBundle<3> rays(CellGeometry<3>(0.1), {0, 0, 0});
    rays.add({0, 0, 0});
    map.insertRays(rays);
    EXPECT_EQ(map.cellTotals().occupied, 1u);
    EXPECT_EQ(drawMap(map.storage(), map.sensorModel(), {}).getWidth(), 1600u);
}

}  // namespace
}  // namespace superray
