// SPDX-License-Identifier: BSD-3-Clause
// Registration of all maps: MRPT finds them by class name when reading streams,
// and by .ini name when creating maps.

#include <dlfcn.h>
#include <mrpt/version.h>
#include <octomap/OcTree.h>
#include <superray/core/version.h>
#include <superray/maps/CSuperRayGridMap2D.h>
#include <superray/maps/CSuperRayGridMap3D.h>
#include <superray/maps/CSuperRayOctoMap.h>
#include <superray/maps/CSuperRayPointsMap.h>
#include <superray/maps/CSuperRayQuadMap.h>
#include <superray/storage/octree.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <string>

namespace superray {
namespace {

/// An empty (or loaded) map from what an .ini file says.
template <class Created, class Map>
Created createFrom(const mrpt::maps::TMetricMapInitializer& definition) {
    const auto& typed = dynamic_cast<const typename Map::TMapDefinition&>(definition);
    TMapOptions options = typed.options;
    options.creation.enableSaveAs3DObject = definition.genericMapParams.enableSaveAs3DObject;
    options.creation.enableObservationLikelihood =
        definition.genericMapParams.enableObservationLikelihood;
    options.creation.enableObservationInsertion =
        definition.genericMapParams.enableObservationInsertion;
    auto map = std::make_unique<Map>(options.creation.resolution);
    map->setOptions(options);
    if constexpr (std::is_pointer_v<Created>) {
        return map.release();
    } else {
        return Created(std::move(map));
    }
}

constexpr unsigned long kMostMapsOfAClass = 100;

/// MRPT makes as many definitions as `<name>_count` says, also for -1, until the memory is
/// full. It reads them one by one, and so the first beyond the limit can stop it.
/// \param prefix "<section>_<name>_<number>"
void refuseTooManyMaps(const std::string& prefix, const std::string& name) {
    const auto numberAt = prefix.find_last_not_of("0123456789") + 1;
    const std::string before = "_" + name + "_";
    if (numberAt <= before.size() || numberAt == prefix.size() ||
        prefix.compare(numberAt - before.size(), before.size(), before) != 0)
        return;  // read by a program of its own, with a section name of its own
    if (std::strtoul(prefix.c_str() + numberAt, nullptr, 10) < kMostMapsOfAClass) return;
    // MRPT takes what stands before a "]" for the place of the error, so none here.
    throw std::invalid_argument(
        name + "_count in section " + prefix.substr(0, numberAt - before.size()) +
        ": must be a whole number from 0 to " + std::to_string(kMostMapsOfAClass));
}

}  // namespace

const octomap::OcTree& CSuperRayOctoMap::octree() const {
    return dynamic_cast<const Octree&>(storage()).tree();
}

}  // namespace superray

/// A program that links this library, rather than loading it as a plugin, may
/// define this to keep the line below away.
extern "C" __attribute__((weak)) const bool superray_linked_knowingly;

/// Copies of this library in the process. Of two, one has all symbols of the other, and
/// what both construct at start is destroyed twice at the end.
extern "C" {
extern int superray_copies_loaded;
int superray_copies_loaded = 0;
}

/// Before all other constructors of this library, which would already do harm.
[[gnu::constructor(101)]] static void refuseSecondCopy() {
    if (superray_copies_loaded++ == 0) return;
    Dl_info info{};
    dladdr(reinterpret_cast<const void*>(&refuseSecondCopy), &info);
    std::fprintf(stderr,
                 "[superray] ERROR: %s is a second copy of the plugin; load only one (see "
                 "LD_PRELOAD, -p, -l)\n",
                 info.dli_fname ? info.dli_fname : "?");
    std::_Exit(EXIT_FAILURE);
}

// MRPT wants each of these per class; a template cannot define them.
#define SUPERRAY_REGISTER_MAP(Class, Base, alias)                                             \
    IMPLEMENTS_SERIALIZABLE(Class, Base, superray)                                            \
    MAP_DEFINITION_REGISTER("superray::" #Class "," alias, superray::Class)                   \
    superray::Class::TMapDefinition::TMapDefinition() = default;                              \
    void superray::Class::TMapDefinition::loadFromConfigFile_map_specific(                    \
        const mrpt::config::CConfigFileBase& source, const std::string& prefix) {             \
        superray::refuseTooManyMaps(prefix, alias);                                           \
        superray::refuseTooManyMaps(prefix, "superray::" #Class);                             \
        options.loadFromConfigFile(source, prefix);                                           \
    }                                                                                         \
    void superray::Class::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out)    \
        const {                                                                               \
        out << options.toText();                                                              \
    }                                                                                         \
    auto superray::Class::internal_CreateFromMapDefinition(                                   \
        const mrpt::maps::TMetricMapInitializer& definition)                                  \
        ->superray::MapCreatorResult {                                                        \
        return superray::createFrom<superray::MapCreatorResult, superray::Class>(definition); \
    }                                                                                         \
    std::uint8_t superray::Class::serializeGetVersion() const {                               \
        return kSerialVersion;                                                                \
    }                                                                                         \
    void superray::Class::serializeTo(mrpt::serialization::CArchive& out) const {             \
        writeTo(out);                                                                         \
    }                                                                                         \
    void superray::Class::serializeFrom(mrpt::serialization::CArchive& in,                    \
                                        std::uint8_t version) {                               \
        readFrom(in, version);                                                                \
    }

SUPERRAY_REGISTER_MAP(CSuperRayGridMap3D, mrpt::maps::CMetricMap, "superRayGridMap3D")
SUPERRAY_REGISTER_MAP(CSuperRayOctoMap, mrpt::maps::CMetricMap, "superRayOctoMap")
SUPERRAY_REGISTER_MAP(CSuperRayGridMap2D, mrpt::maps::CMetricMap, "superRayGridMap2D")
SUPERRAY_REGISTER_MAP(CSuperRayQuadMap, mrpt::maps::CMetricMap, "superRayQuadMap")
SUPERRAY_REGISTER_MAP(CSuperRayPointsMap2D, mrpt::maps::CSimplePointsMap, "superRayPointsMap2D")
SUPERRAY_REGISTER_MAP(CSuperRayPointsMap3D, mrpt::maps::CSimplePointsMap, "superRayPointsMap3D")
#undef SUPERRAY_REGISTER_MAP

namespace {

/// Below the class ids that it registers, so constructed after them; an
/// MRPT_INITIALIZER in this file would run before.
const bool registered = [] {
    using namespace superray;
    mrpt::rtti::registerClass(CLASS_ID(CSuperRayGridMap3D));
    mrpt::rtti::registerClass(CLASS_ID(CSuperRayOctoMap));
    mrpt::rtti::registerClass(CLASS_ID(CSuperRayGridMap2D));
    mrpt::rtti::registerClass(CLASS_ID(CSuperRayQuadMap));
    mrpt::rtti::registerClass(CLASS_ID(CSuperRayPointsMap2D));
    mrpt::rtti::registerClass(CLASS_ID(CSuperRayPointsMap3D));
    // A user whose plugin did not load sees nothing, so say that it did. On
    // stderr: programs that link the library may print data on stdout.
    if (&superray_linked_knowingly == nullptr && !std::getenv("SUPERRAY_QUIET"))
        std::cerr << "[superray] INFO: superray " SUPERRAY_VERSION " (" << MRPT_version_str
                  << "): map classes registered: "
                     "superRayGridMap3D, superRayOctoMap, superRayGridMap2D, "
                     "superRayQuadMap, superRayPointsMap2D, superRayPointsMap3D\n";
    return true;
}();

}  // namespace
