// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/map_factory.h>

#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/maps/octomap_input.h>
#include <superray/maps/option_text.h>

#include <algorithm>
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

constexpr char kCount[] = "_count";

/// A misspelt name would leave its map out without a word. MRPT refuses it since 2.11.3.
void refuseUnknownNames(const mrpt::config::CConfigFileBase& source,
                        const std::string& section) {
    const auto& registered =
        mrpt::maps::internal::TMetricMapTypesRegistry::Instance().getAllRegistered();
    std::vector<std::string> known;
    known.reserve(registered.size());
    for (const auto& [name, functions] : registered) known.push_back(name);
    for (const auto& name : countedMapNames(source, section)) {
        if (std::any_of(known.begin(), known.end(),
                        [&](const std::string& k) { return equalIgnoringCase(k, name); }))
            continue;
        std::ostringstream message;
        message << "[" << section << "] " << shortened(name) << kCount
                << ": unknown map; did you mean " << closestTo(name, known) << kCount << "?";
        throw std::invalid_argument(message.str());
    }
}

[[noreturn]] void failWithSeveral(const std::string& section, const std::string& iniName,
                                  std::uint32_t count) {
    std::ostringstream message;
    message << "[" << section << "]: defines several superray maps (" << iniName << kCount
            << " = " << count << "); must define one";
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
    throw std::invalid_argument("map class \"" + shortened(className) + "\": must be one of " +
                                valid);
}

std::vector<std::string> countedMapNames(const mrpt::config::CConfigFileBase& source,
                                         const std::string& section) {
    const std::size_t ending = std::string(kCount).size();
    std::vector<std::string> keys, names;
    source.getAllKeys(section, keys);
    for (const auto& key : keys)
        if (key.size() > ending && equalIgnoringCase(key.substr(key.size() - ending), kCount))
            names.push_back(key.substr(0, key.size() - ending));
    return names;
}

MapPtr createMapFromConfig(const mrpt::config::CConfigFileBase& source,
                           const std::string& section) {
    // Not by MRPT's TSetOfMetricMapInitializers, which makes as many definitions as the
    // section says (-1 is four thousand million) before anyone can look at them.
    refuseUnknownNames(source, section);
    StrictSection keys(source, section);
    std::string defined, valid;
    for (const auto& c : kClasses) {
        valid += (valid.empty() ? "" : ", ") + std::string(c.alias) + kCount + " = 1";
        for (const auto& name : {std::string(c.alias), "superray::" + std::string(c.name)}) {
            std::uint32_t count = 0;
            keys.read(name + kCount, count);
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
