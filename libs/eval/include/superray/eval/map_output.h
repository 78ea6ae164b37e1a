// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_output.h
/// Writing maps for other programs: whole files or none.

#include <superray/eval/map_picture.h>
#include <superray/maps/super_ray_map_interface.h>

#include <string>
#include <vector>

namespace superray {

/// The files that exportMap() writes: `path`, and what belongs beside it.
std::vector<std::string> filesOfExport(const SuperRayMapInterface& map,
                                       const std::string& path);

/// Writes a map in the format of the extension: .bt, .ot (OctoMap, 3D), .ply,
/// .3Dscene (MRPT), .png (picture; of a 2D map with a .yaml beside it), .yaml (2D; with a
/// .pgm beside it, for map_server and nav2) or .gridmap (2D; MRPT), by the rules of
/// AtomicFile: an error
/// leaves an old file as it was.
/// \throws InputError for an unknown extension or a format that the map cannot
///         take; MapFileError if it cannot be written
void exportMap(const SuperRayMapInterface& map, const std::string& path,
               const PictureOptions& picture = {});

/// "path, size" of a written file; of a FIFO or device the path alone.
std::string describeOutput(const std::string& path);

}  // namespace superray
