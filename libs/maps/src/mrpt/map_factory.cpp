// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/map_factory.h>

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/maps/octomap_input.h>

#include <array>
#include <stdexcept>

namespace superray {
namespace {

using MapPtr = mrpt::maps::CMetricMap::Ptr;

struct MapClass {
    const char* name;
    const char* alias;
    MapPtr (*make)();
};

template <class Map>
MapPtr make() {
    return std::make_shared<Map>();
}

constexpr std::array<MapClass, 4> kClasses{{
    {"CSuperRayGridMap3D", "superRayGridMap3D", make<CSuperRayGridMap3D>},
    {"CSuperRayOctoMap", "superRayOctoMap", make<CSuperRayOctoMap>},
    {"CSuperRayGridMap2D", "superRayGridMap2D", make<CSuperRayGridMap2D>},
    {"CSuperRayQuadMap", "superRayQuadMap", make<CSuperRayQuadMap>},
}};

}  // namespace

std::vector<std::string> mapClassNames() {
    std::vector<std::string> names;
    for (const auto& c : kClasses) names.emplace_back(c.name);
    return names;
}

MapPtr createMap(const std::string& className) {
    std::string valid;
    for (const auto& c : kClasses) {
        if (className == c.name || className == c.alias ||
            className == std::string("superray::") + c.name)
            return c.make();
        valid += (valid.empty() ? "" : ", ") + std::string(c.name);
    }
    throw std::invalid_argument("map class \"" + className + "\": must be one of " + valid);
}

MapPtr createMapFromConfig(const mrpt::config::CConfigFileBase& source,
                           const std::string& section) {
    mrpt::maps::TSetOfMetricMapInitializers definitions;
    definitions.loadFromConfigFile(source, section);
    MapPtr created;
    for (const auto& definition : definitions) {
        for (const auto& c : kClasses) {
            if (std::string("superray::") + c.name !=
                definition->getMetricMapClassType()->className)
                continue;
            if (created)
                throw std::invalid_argument(
                    "[" + section + "]: defines several superray maps; " + "must define one");
            created = MapPtr(mrpt::maps::internal::TMetricMapTypesRegistry::Instance()
                                 .factoryMapObjectFromDefinition(*definition));
        }
    }
    if (!created) {
        std::string valid;
        for (const auto& c : kClasses)
            valid += (valid.empty() ? "" : ", ") + std::string(c.alias) + "_count = 1";
        throw std::invalid_argument("[" + section + "]: defines no superray map; add one of " +
                                    valid);
    }
    return created;
}

MapPtr loadMap(const std::string& path) {
    if (isOctomapFile(path)) {
        const auto map = std::make_shared<CSuperRayOctoMap>();
        map->loadFromFile(path);
        return map;
    }
    // Reads the file twice in the worst case; the cells stay packed here.
    const std::string name = loadMapFile(path).header.className;
    MapPtr map;
    try {
        map = createMap(name);
    } catch (const std::invalid_argument& e) {
        throw MapFileError(path + ": " + e.what());
    }
    dynamic_cast<SuperRayMapInterface&>(*map).loadFromFile(path);
    return map;
}

}  // namespace superray
