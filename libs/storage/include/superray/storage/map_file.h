// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_file.h
/// The native file (.srmap): sections with length and checksum, validated
/// before anything is allocated or replaced; see doc/file_format.md.

#include <superray/storage/map_file_error.h>
#include <superray/storage/memory_limit_error.h>
#include <superray/storage/occupancy_map.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace superray {

enum class StorageType : std::uint8_t { blockGrid, tree };

/// An empty storage. `tree` is Octree in 3D, Quadtree in 2D.
template <int Dim>
std::unique_ptr<OccupancyMap<Dim>> makeStorage(StorageType type,
                                               const CellGeometry<Dim>& geometry);

/// What reading may ask for, checked before memory is taken.
struct MapFileLimits {
    std::uint64_t fileBytes;  ///< size of a file
    std::uint64_t mapBytes;   ///< memory of the cells, as the counts in the header say
    /// Memory that the map holds while cells are read into it; more is MemoryLimitError.
    std::uint64_t heldBytes = std::numeric_limits<std::uint64_t>::max();

    /// For each half of the machine's memory or, if the environment variable
    /// SUPERRAY_MAP_MEGABYTES is a whole number, so many MiB.
    static MapFileLimits ofThisMachine();
};

/// SUPERRAY_MAP_MEGABYTES [bytes], if that is a whole number.
std::optional<std::uint64_t> mapBytesOfEnvironment();

/// Everything but the cells.
struct MapFileHeader {
    std::string className;  ///< e.g. "CSuperRayGridMap3D"
    int dimension = 3;
    double resolution = 0;
    std::string options;  ///< .ini text of all options, opaque here
};

/// Cells of a map as bytes (deflated, versioned, checksummed), independent of
/// storage type; the payload of files and of MRPT serialisation.
template <int Dim>
std::vector<std::uint8_t> encodeCells(const OccupancyMap<Dim>& map);
/// Replaces the contents of `map`; on any error throws MapFileError (for more memory
/// than limits.heldBytes: MemoryLimitError) and leaves it untouched. Sizes are validated before
/// memory is taken.
template <int Dim>
void decodeCells(const std::uint8_t* data, std::size_t size, OccupancyMap<Dim>& map,
                 const MapFileLimits& limits = MapFileLimits::ofThisMachine());

/// Writes to a temporary file beside `path`, syncs, renames: a failure leaves
/// an old file whole. \throws MapFileError
void saveMapFile(const std::string& path, const MapFileHeader& header,
                 const std::vector<std::uint8_t>& cells);

struct MapFile {
    MapFileHeader header;
    std::vector<std::uint8_t> cells;  ///< for decodeCells()
};
/// Reads and validates the container (magic, version, lengths, checksums).
/// The preamble is checked before the rest is read. \throws MapFileError
MapFile loadMapFile(const std::string& path,
                    const MapFileLimits& limits = MapFileLimits::ofThisMachine());
/// Same, from memory (tests, fuzzing). `name` is used in messages.
MapFile parseMapFile(const std::uint8_t* data, std::size_t size, const std::string& name);

}  // namespace superray
