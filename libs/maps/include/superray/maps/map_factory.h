// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_factory.h
/// Maps by name, from .ini sections and from files.

#include <mrpt/maps/CMetricMap.h>

#include <string>
#include <vector>

namespace mrpt::config {
class CConfigFileBase;
}

namespace superray {

/// "CSuperRayGridMap3D", ... in the order of registration.
std::vector<std::string> mapClassNames();

/// An empty map with default options.
/// \param className "CSuperRayGridMap3D", "superray::CSuperRayGridMap3D" or the
///        .ini name "superRayGridMap3D"
/// \throws std::invalid_argument listing the valid names
mrpt::maps::CMetricMap::Ptr createMap(const std::string& className);

/// The names X of all keys `X_count` of a section, of any library's maps, as they are
/// written there; none if it is no multi-metric-map section.
std::vector<std::string> countedMapNames(const mrpt::config::CConfigFileBase& source,
                                         const std::string& section);

/// The one map of this library that a multi-metric-map section defines
/// (`superRayGridMap3D_count = 1` in [section], options in
/// [section_superRayGridMap3D_00_...]); other maps in it are left alone.
/// \throws std::invalid_argument if it defines none or several, for a count that is no whole
///         number or of a map that no library has registered, and for bad options
mrpt::maps::CMetricMap::Ptr createMapFromConfig(const mrpt::config::CConfigFileBase& source,
                                                const std::string& section);

/// Reads a native file into a map of the class that wrote it, or a file of OctoMap (.bt,
/// .ot) into a CSuperRayOctoMap.
/// \throws MapFileError
mrpt::maps::CMetricMap::Ptr loadMap(const std::string& path);

}  // namespace superray
