// SPDX-License-Identifier: BSD-3-Clause
// The maps as MRPT's .ini files and registries see them.

#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>

#include <set>
#include <sstream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::config::CConfigFileMemory;

mrpt::maps::CMultiMetricMap makeMaps(const mrpt::config::CConfigFileBase& file,
                                     const std::string& section) {
    mrpt::maps::TSetOfMetricMapInitializers definitions;
    definitions.loadFromConfigFile(file, section);
    mrpt::maps::CMultiMetricMap maps;
    maps.setListOfMaps(definitions);
    return maps;
}

TEST(Registration, AllFourFromOneIniFile) {
    const CConfigFileMemory file(
        std::string("[map]\n"
                    "superRayGridMap3D_count = 1\n"
                    "superRayOctoMap_count = 1\n"
                    "superRayGridMap2D_count = 1\n"
                    "superRayQuadMap_count = 1\n"
                    "pointsMap_count = 1\n"
                    "[map_superRayGridMap3D_00_creationOpts]\n"
                    "resolution = 0.05 // m\n"
                    "enableObservationLikelihood = false\n"
                    "[map_superRayGridMap3D_00_insertOpts]\n"
                    "maxrange = 5\n"
                    "policy = oncePerScan\n"
                    "[map_superRayGridMap3D_00_likelihoodOpts]\n"
                    "decimation = 10\n"
                    "[map_superRayGridMap3D_00_renderOpts]\n"
                    "colour = occupancy\n"
                    "[map_superRayQuadMap_00_creationOpts]\n"
                    "resolution = 0.4\n"));
    auto maps = makeMaps(file, "map");
    ASSERT_EQ(maps.maps.size(), 5u);
    std::set<std::string> found;
    for (const auto& map : maps.maps) {
        auto* super = dynamic_cast<SuperRayMapInterface*>(&*map);
        if (!super) continue;
        found.insert(super->shortClassName());
        const auto o = super->options();
        if (super->shortClassName() == "CSuperRayGridMap3D") {
            EXPECT_EQ(o.creation.resolution, 0.05);
            EXPECT_FALSE(map->genericMapParams.enableObservationLikelihood);
            EXPECT_TRUE(map->genericMapParams.enableObservationInsertion);
            EXPECT_EQ(o.insertion.maxrange, 5);
            EXPECT_EQ(o.insertion.policy, UpdatePolicy::oncePerScan);
            EXPECT_EQ(o.likelihood.decimation, 10u);
            EXPECT_EQ(o.rendering.colour, VoxelColour::occupancy);
        }
        if (super->shortClassName() == "CSuperRayQuadMap") {
            EXPECT_EQ(super->resolution(), 0.4);
        }
        if (super->shortClassName() == "CSuperRayOctoMap") {
            EXPECT_EQ(super->optionsAsIniText(), TMapOptions().toText());
        }
    }
    const auto names = mapClassNames();
    EXPECT_EQ(found, std::set<std::string>(names.begin(), names.end()));
    EXPECT_TRUE(maps.isEmpty());
    ASSERT_TRUE(maps.insertObservation(*test::randomCloud(200, 1)));
    for (const auto& map : maps.maps) EXPECT_FALSE(map->isEmpty());
    // What CMultiMetricMap asks of each of its maps must not throw.
    mrpt::maps::CSimplePointsMap points;
    points.insertPoint(1, 1, 1);
    EXPECT_NO_THROW(maps.compute3DMatchingRatio(&points, mrpt::poses::CPose3D(), {}));
    EXPECT_NO_THROW(maps.getVisualization());
}

TEST(Registration, BadIniFilesSayWhatIsWrong) {
    const auto messageFor = [](const std::string& lines) {
        return test::messageOf([&] {
            makeMaps(CConfigFileMemory("[map]\nsuperRayOctoMap_count = 1\n" + lines), "map");
        });
    };
    auto message = messageFor("[map_superRayOctoMap_00_insertOpts]\nprobHt = 0.8\n");
    EXPECT_CONTAINS(message, "map_superRayOctoMap_00_insertOpts");
    EXPECT_CONTAINS(message, "did you mean probHit?");
    message = messageFor("[map_superRayOctoMap_00_creationOpts]\nresolution = -1\n");
    EXPECT_CONTAINS(message, "resolution = -1");
    message = messageFor("[map_superRayOctoMap_00_renderingOpts]\ncolour = height\n");
    EXPECT_CONTAINS(message, "did you mean [map_superRayOctoMap_00_renderOpts]?");
    message = messageFor("[map_superRayOctoMap_00_creationOpts]\nload_from = /no/such.srmap\n");
    EXPECT_CONTAINS(message, "/no/such.srmap");
    EXPECT_EQ(messageFor(""), "");
}

TEST(Registration, LoadFromStartsWithASavedMap) {
    const test::TempFolder folder;
    CSuperRayGridMap3D saved(0.25);
    ASSERT_TRUE(saved.insertObservation(*test::randomCloud(200, 1)));
    saved.saveToFile(folder.file("saved.srmap"));
    const CConfigFileMemory file(
        "[m]\nsuperRayOctoMap_count=1\n[m_superRayOctoMap_00_creationOpts]\n"
        "load_from = " +
        folder.file("saved.srmap") + "\n[m_superRayOctoMap_00_insertOpts]\nmaxrange = 3\n");
    const auto map = createMapFromConfig(file, "m");
    const auto& super = test::interfaceOf(*map);
    EXPECT_EQ(super.shortClassName(), "CSuperRayOctoMap");
    EXPECT_EQ(super.digest(), saved.digest());
    EXPECT_EQ(super.options().insertion.maxrange, 3);
    EXPECT_EQ(super.resolution(), 0.25);

    const auto other = createMap("CSuperRayGridMap3D");
    test::interfaceOf(*other).setOptionsFromConfig(file, "m_superRayOctoMap_00");
    EXPECT_EQ(test::interfaceOf(*other).digest(), saved.digest());
    EXPECT_EQ(test::interfaceOf(*other).optionsAsIniText(), super.optionsAsIniText());
}

TEST(Registration, DefinitionsByClassNameAndDump) {
    for (const std::string name : {"superray::CSuperRayGridMap3D", "superRayGridMap3D"}) {
        const std::shared_ptr<mrpt::maps::TMetricMapInitializer> definition(
            mrpt::maps::TMetricMapInitializer::factory(name));
        ASSERT_TRUE(definition) << name;
        std::ostringstream text;
        definition->dumpToTextStream(text);
        EXPECT_CONTAINS(text.str(), "superRayThreshold = 20");
    }
}

TEST(Factory, NamesOfAllKindsAndAListForOthers) {
    EXPECT_EQ(mapClassNames().size(), 4u);
    for (const std::string name :
         {"CSuperRayOctoMap", "superray::CSuperRayOctoMap", "superRayOctoMap"})
        EXPECT_EQ(test::interfaceOf(*createMap(name)).shortClassName(), "CSuperRayOctoMap");
    const auto message = test::messageOf([] { createMap("COctoMap"); });
    EXPECT_CONTAINS(message, "\"COctoMap\"");
    for (const auto& name : mapClassNames()) EXPECT_CONTAINS(message, name);
}

TEST(Factory, ConfigMustDefineOneMap) {
    EXPECT_CONTAINS(test::messageOf([] {
                        createMapFromConfig(
                            CConfigFileMemory(std::string("[a]\npointsMap_count=1\n")), "a");
                    }),
                    "superRayGridMap3D_count = 1");
    EXPECT_CONTAINS(test::messageOf([] {
                        createMapFromConfig(
                            CConfigFileMemory(std::string("[a]\nsuperRayGridMap3D_count=2\n")),
                            "a");
                    }),
                    "several");
}

// MRPT takes -1 for four thousand million maps and fills the memory with them.
TEST(Factory, CountsAreWholeNumbersOfOneMapInAll) {
    const auto messageFor = [](const std::string& lines) {
        return test::messageOf(
            [&] { createMapFromConfig(CConfigFileMemory("[a]\n" + lines), "a"); });
    };
    for (const std::string name :
         {"superRayGridMap2D", "superray::CSuperRayOctoMap", "SUPERRAYQUADMAP"}) {
        for (const std::string count : {"-1", "2.5", "x", "", "0x1", "18446744073709551616"}) {
            const auto message = messageFor(name + "_count = " + count + "\n");
            EXPECT_CONTAINS(message, name + "_count = " + count);
            EXPECT_CONTAINS(message, "whole number");
        }
    }
    EXPECT_CONTAINS(messageFor("superRayGridMap2D_count = 1000000000\n"),
                    "superRayGridMap2D_count = 1000000000");
    EXPECT_CONTAINS(messageFor("superRayGridMap2D_count = 1\nsuperRayOctoMap_count = 1\n"),
                    "several");
    EXPECT_CONTAINS(
        messageFor("superRayOctoMap_count = 1\nsuperray::CSuperRayOctoMap_count = 1\n"),
        "several");
    EXPECT_CONTAINS(messageFor("superRayGridMap2D_count = 0\n"), "no superray map");
    EXPECT_EQ(messageFor("superRayGridMap2D_count = 1 // maps\nsuperRayOctoMap_count = 0\n"
                         "pointsMap_count = -1\n"),
              "");
}

TEST(Factory, CountsOfUnknownMapsAreRefused) {
    const auto messageFor = [](const std::string& lines) {
        return test::messageOf([&] {
            createMapFromConfig(CConfigFileMemory("[a]\nsuperRayOctoMap_count = 1\n" + lines),
                                "a");
        });
    };
    const auto message = messageFor("superRayGridMpa2D_count = 1\n");
    EXPECT_CONTAINS(message, "superRayGridMpa2D_count");
    EXPECT_CONTAINS(message, "did you mean superRayGridMap2D_count?");
    EXPECT_EQ(messageFor("POINTSMAP_COUNT = 1\n"), "");
}

// A stock program asks MRPT, which asks us for one definition after the other.
TEST(Registration, TooManyMapsOfAClassAreRefusedInMrptToo) {
    for (const std::string name :
         {"superRayGridMap2D", "superray::CSuperRayOctoMap", "superRayPointsMap3D"}) {
        for (const std::string count : {"-1", "1000000000", "101"}) {
            const auto message = test::messageOf([&] {
                makeMaps(CConfigFileMemory("[map]\n" + name + "_count = " + count + "\n"),
                         "map");
            });
            EXPECT_CONTAINS(message, name + "_count in section map: must be");
            EXPECT_CONTAINS(message, "from 0 to 100");
        }
        mrpt::maps::TSetOfMetricMapInitializers definitions;
        definitions.loadFromConfigFile(CConfigFileMemory("[map]\n" + name + "_count = 100\n"),
                                       "map");
        EXPECT_EQ(definitions.size(), 100u);
    }
    const std::shared_ptr<mrpt::maps::TMetricMapInitializer> own(
        mrpt::maps::TMetricMapInitializer::factory("superRayOctoMap"));
    EXPECT_NO_THROW(own->loadFromConfigFile(CConfigFileMemory(std::string()), "yard_2026"));
}

struct ConfigFile {
    const char *name, *section;
    std::set<std::string> classes;
};

TEST(ConfigFiles, AllLoad) {
    const std::vector<ConfigFile> files{
        {"superray-maps-basic.ini", "map", {"CSuperRayOctoMap"}},
        {"superray-maps-advanced.ini",
         "map",
         {"CSuperRayGridMap3D", "CSuperRayOctoMap", "CSuperRayGridMap2D", "CSuperRayQuadMap"}},
        {"icp-slam-superray.ini",
         "MappingApplication",
         {"CSuperRayOctoMap", "CSuperRayGridMap2D"}},
    };
    for (const auto& f : files) {
        const mrpt::config::CConfigFile file(SUPERRAY_CONFIG_FILES_DIR "/" +
                                             std::string(f.name));
        const auto maps = makeMaps(file, f.section);
        std::set<std::string> found;
        for (const auto& map : maps.maps)
            if (const auto* super = dynamic_cast<const SuperRayMapInterface*>(&*map))
                found.insert(super->shortClassName());
        EXPECT_EQ(found, f.classes) << f.name;
    }
}

TEST(ConfigFiles, TheAdvancedOneNamesEveryOptionWithItsDefault) {
    const mrpt::config::CConfigFile file(SUPERRAY_CONFIG_FILES_DIR
                                         "/superray-maps-advanced.ini");
    TMapOptions o;
    o.loadFromConfigFile(file, "map_superRayGridMap3D_00");
    EXPECT_EQ(o.toText(), TMapOptions().toText());
    std::istringstream lines(o.toText());
    std::string section;
    std::size_t options = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.front() == '[') {
            section = "map_superRayGridMap3D_00_" + line.substr(1, line.size() - 2);
        } else {
            ++options;
            const auto key = line.substr(0, line.find(' '));
            EXPECT_TRUE(file.keyExists(section, key)) << section << " " << key;
        }
    }
    EXPECT_EQ(options, 43u);
}

}  // namespace
}  // namespace superray
