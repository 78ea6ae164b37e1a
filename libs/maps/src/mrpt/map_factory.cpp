// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/map_factory.h>

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/maps/octomap_input.h>
#include <superray/maps/option_text.h>

#include <array>
#include <sstream>
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

/// How many maps of this .ini name the section asks for.
std::uint32_t countOfMaps(const mrpt::config::CConfigFileBase& source,
                          const std::string& section, const std::string& iniName) {
    std::uint32_t count = 0;
    StrictSection(source, section).read(iniName + "_count", count);
    return count;
}

[[noreturn]] void failWithSeveral(const std::string& section, const std::string& iniName,
                                  std::uint32_t count) {
    std::ostringstream message;
    message << "[" << section << "]: defines several superray maps (" << iniName
            << "_count = " << count << "); must define one";
    throw std::invalid_argument(message.str());
}

}  // namespace

std::vector<std::string> mapClassNames() {
    std::vector<std::string> names;
    names.reserve(kClasses.size());
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
    // Not by MRPT's TSetOfMetricMapInitializers, which makes as many definitions as the
    // section says (-1 is four thousand million) before anyone can look at them.
    std::string defined, valid;
    for (const auto& c : kClasses) {
        valid += (valid.empty() ? "" : ", ") + std::string(c.alias) + "_count = 1";
        for (const auto& name : {std::string(c.alias), "superray::" + std::string(c.name)}) {
            const std::uint32_t count = countOfMaps(source, section, name);
            if (count > 1 || (count == 1 && !defined.empty()))
                failWithSeveral(section, name, count);
            if (count == 1) defined = name;
        }
    }
    if (defined.empty())
        throw std::invalid_argument("[" + section + "]: defines no superray map; add one of " +
                                    valid);
    const std::shared_ptr<mrpt::maps::TMetricMapInitializer> definition(
        mrpt::maps::TMetricMapInitializer::factory(defined));
    definition->loadFromConfigFile(source, section + "_" + defined + "_00");
    return MapPtr(mrpt::maps::internal::TMetricMapTypesRegistry::Instance()
                      .factoryMapObjectFromDefinition(*definition));
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
