// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/config_text.h>
#include <superray/eval/input_error.h>
#include <superray/eval/map_request.h>
#include <superray/maps/map_factory.h>
#include <superray/maps/option_text.h>
#include <superray/maps/super_ray_map_interface.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace superray {
namespace {

constexpr char kDefaultClass[] = "CSuperRayGridMap3D";

SuperRayMapInterface& interfaceOf(mrpt::maps::CMetricMap& map) {
    return dynamic_cast<SuperRayMapInterface&>(map);
}

mrpt::maps::CMetricMap::Ptr fromConfig(const MapRequest& request) {
    if (request.section.empty())
        throw InputError(request.configFile +
                         ": which section of the configuration file? (--section S)");
    const auto config = readConfigFile(request.configFile, [&](const std::string& section) {
        const std::string ours = section.substr(0, request.section.size());
        return equalIgnoringCase(ours, request.section) &&
               (section.size() == ours.size() || section[ours.size()] == '_');
    });
    std::vector<std::string> sections;
    config.getAllSections(sections);
    const bool named = std::any_of(sections.begin(), sections.end(), [&](const auto& s) {
        return s == request.section || startsWith(s, request.section + "_");
    });
    if (!named)
        throw InputError(request.configFile + ": has neither a section [" + request.section +
                         "] nor any [" + request.section + "_...]");
    try {
        if (!countedMapNames(config, request.section).empty()) {
            auto map = createMapFromConfig(config, request.section);
            if (!request.className) return map;
            auto other = createMap(*request.className);
            interfaceOf(*other).setOptions(interfaceOf(*map).options());
            return other;
        }
        auto map = createMap(request.className.value_or(kDefaultClass));
        interfaceOf(*map).setOptionsFromConfig(config, request.section);
        return map;
    } catch (const std::exception& e) {
        throw InputError(request.configFile + ": " + oneLineCause(e));
    }
}

}  // namespace

mrpt::maps::CMetricMap::Ptr makeMap(const MapRequest& request) {
    if (request.configFile.empty() && !request.section.empty())
        throw InputError("a section ('" + request.section + "') needs a configuration file");
    auto map = request.configFile.empty() ? createMap(request.className.value_or(kDefaultClass))
                                          : fromConfig(request);
    TMapOptions options = interfaceOf(*map).options();
    auto& insertion = options.insertion;
    options.creation.resolution = request.resolution.value_or(options.creation.resolution);
    insertion.maxrange = request.maxRange.value_or(insertion.maxrange);
    insertion.minrange = request.minRange.value_or(insertion.minrange);
    insertion.windowRadius = request.windowRadius.value_or(insertion.windowRadius);
    options.creation.max_memory_megabytes =
        request.maxMemoryMegabytes.value_or(options.creation.max_memory_megabytes);
    insertion.threads = request.threads.value_or(insertion.threads);
    insertion.sensorLabel = request.sensorLabels.value_or(insertion.sensorLabel);
    if (request.policy) {
        const UpdatePolicy policy = updatePolicyFromString(*request.policy);
        if (policy != insertion.policy) insertion.setPolicy(policy);
    }
    if (request.method) insertion.method = methodFromString(*request.method);
    interfaceOf(*map).setOptions(options);
    return map;
}

}  // namespace superray
