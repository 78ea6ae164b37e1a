// SPDX-License-Identifier: BSD-3-Clause
// Reading and writing whole maps: native files and MRPT streams.

#include <mrpt/serialization/CArchive.h>
#include <superray/maps/octomap_input.h>
#include <superray/maps/super_ray_map_base.h>
#include <superray/storage/for_each_cell.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <vector>

namespace superray {
namespace {

/// FNV-1a: guards the options in a stream (the cells have their own checksum).
std::uint64_t checksum(const std::string& text) {
    std::uint64_t h = 0xCBF29CE484222325ull;
    for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001B3ull;
    return h;
}

template <class Bytes>
void writeBytes(mrpt::serialization::CArchive& out, const Bytes& bytes) {
    out << static_cast<std::uint64_t>(bytes.size());
    if (!bytes.empty()) out.WriteBuffer(bytes.data(), bytes.size());
}

/// Grows as data arrive: a wrong size runs into the end of the stream, not
/// into a huge allocation.
template <class Bytes>
Bytes readBytes(mrpt::serialization::CArchive& in) {
    constexpr std::uint64_t kStep = 1u << 20;
    std::uint64_t left = 0;
    in >> left;
    Bytes bytes;
    while (left > 0) {
        const auto step = static_cast<std::size_t>(std::min(left, kStep));
        const std::size_t had = bytes.size();
        bytes.resize(had + step);
        if (in.ReadBuffer(&bytes[had], step) != step)
            throw std::runtime_error("unexpected end of stream");
        left -= step;
    }
    return bytes;
}

MapFileLimits limitsWithin(std::uint32_t boundMegabytes) {
    MapFileLimits limits = MapFileLimits::ofThisMachine();
    if (boundMegabytes != 0) limits.heldBytes = std::uint64_t{boundMegabytes} << 20;
    return limits;
}

/// Cells of an OctoMap file; .bt has only two values, which become the clamps.
std::unique_ptr<OccupancyMap<3>> readOctomapCells(const std::string& path,
                                                  const SensorModel& model) {
    OctomapFile file = loadOctomapFile(path);
    if (!file.note.empty()) std::cerr << "[superray] " << path << ": " << file.note << "\n";
    if (file.values == CellValues::logOdds) return std::move(file.map);
    auto cells = makeStorage<3>(StorageType::blockGrid, file.map->geometry());
    forEachCell(*file.map, [&](const Cell<3>& cell, float value) {
        cells->setLogOdds(cell, value > 0 ? model.max() : model.min());
    });
    return cells;
}

}  // namespace

/// The options of a map to be saved. They are public members, so anything may be in them.
/// \throws std::invalid_argument for options with which the map could not be loaded
static std::string loadableText(const TMapOptions& options) {
    options.validate();
    return options.toText();
}

template <int Dim>
void CSuperRayMapBase<Dim>::writeTo(mrpt::serialization::CArchive& out) const {
    const std::string text = loadableText(options());
    writeBytes(out, text);
    out << checksum(text);
    writeBytes(out, *storage_.encoded());
}

template <int Dim>
void CSuperRayMapBase<Dim>::readFrom(mrpt::serialization::CArchive& in, std::uint8_t version) {
    try {
        if (version > kSerialVersion)
            throw std::runtime_error("version " + std::to_string(version) +
                                     " is newer than this library's, " +
                                     std::to_string(kSerialVersion));
        const auto text = readBytes<std::string>(in);
        std::uint64_t sum = 0;
        in >> sum;
        if (sum != checksum(text)) throw std::runtime_error("checksum of the options is wrong");
        TMapOptions read;
        read.fromText(text);
        const auto cells = readBytes<std::vector<std::uint8_t>>(in);
        replaceAll(
            SharedStorage<Dim>::decoded(type_, CellGeometry<Dim>(read.creation.resolution),
                                        cells, limitsWithin(maxMegabytes_)),
            read, maxMegabytes_);
    } catch (const MemoryLimitError&) {
        throw;
    } catch (const std::exception& e) {
        throw std::runtime_error(shortClassName() +
                                 ": cannot read map from stream: " + e.what());
    }
}

template <int Dim>
void CSuperRayMapBase<Dim>::saveToFile(const std::string& path) const {
    MapFileHeader header;
    header.className = shortClassName();
    header.dimension = Dim;
    header.resolution = resolution();
    try {
        header.options = loadableText(options());
    } catch (const std::invalid_argument& e) {
        throw MapFileError(path + ": not written: " + e.what());
    }
    saveMapFile(path, header, encodeCells(*storage_));
}

template <int Dim>
void CSuperRayMapBase<Dim>::loadFromFile(const std::string& path) {
    loadWithin(path, maxMegabytes_);
}

template <int Dim>
void CSuperRayMapBase<Dim>::loadWithin(const std::string& path, std::uint32_t boundMegabytes) {
    const MapFileLimits limits = limitsWithin(boundMegabytes);
    if (isOctomapFile(path)) {
        if constexpr (Dim == 3) {
            TMapOptions read = options();
            const auto cells = readOctomapCells(path, sensorModel());
            read.creation.resolution = cells->geometry().resolution();
            return replaceAll(SharedStorage<Dim>::decoded(type_, cells->geometry(),
                                                          encodeCells(*cells), limits),
                              read, boundMegabytes);
        }
        throw MapFileError(path + ": OctoMap's files hold 3D maps; " + shortClassName() +
                           " can load 2D maps only");
    }
    const MapFile file = loadMapFile(path);
    if (file.header.dimension != Dim)
        throw MapFileError(path + ": holds a " + std::to_string(file.header.dimension) +
                           "D map (" + file.header.className + "); " + shortClassName() +
                           " can load " + std::to_string(Dim) + "D maps only");
    TMapOptions read;
    try {
        read.creation.resolution = file.header.resolution;
        read.fromText(file.header.options);
        if (read.creation.resolution != file.header.resolution)
            throw std::invalid_argument("resolution " + metresText(read.creation.resolution) +
                                        " in the options, but " +
                                        metresText(file.header.resolution) + " in the header");
        read.creation.validate();
    } catch (const std::invalid_argument& e) {
        throw MapFileError(path + ": " + e.what());
    }
    replaceAll(SharedStorage<Dim>::decoded(type_, CellGeometry<Dim>(read.creation.resolution),
                                           file.cells, limits),
               read, boundMegabytes);
}

template <int Dim>
void CSuperRayMapBase<Dim>::saveMetricMapRepresentationToFile(const std::string& prefix) const {
    // Before anything is written. "out/.bt" would be a hidden file without an extension.
    if (!std::filesystem::path(prefix).has_filename())
        throw MapFileError("prefix \"" + prefix +
                           "\" of map files: has no file name; must end in one, as \"" +
                           prefix + "map\"");
    saveToFile(prefix + ".srmap");
    exportScene(prefix + ".3Dscene");
    if constexpr (Dim == 3) {
        this->exportOctomap(prefix + ".bt");
        this->exportOctomap(prefix + ".ot");
    } else {
        try {
            this->exportPicture(prefix + ".png");
        } catch (const std::invalid_argument& tooLarge) {
            // The map itself is saved: no reason to stop the caller.
            std::cerr << "[superray] " << tooLarge.what() << "\n";
        }
    }
}

template void CSuperRayMapBase<2>::writeTo(mrpt::serialization::CArchive&) const;
template void CSuperRayMapBase<3>::writeTo(mrpt::serialization::CArchive&) const;
template void CSuperRayMapBase<2>::readFrom(mrpt::serialization::CArchive&, std::uint8_t);
template void CSuperRayMapBase<3>::readFrom(mrpt::serialization::CArchive&, std::uint8_t);
template void CSuperRayMapBase<2>::saveToFile(const std::string&) const;
template void CSuperRayMapBase<3>::saveToFile(const std::string&) const;
template void CSuperRayMapBase<2>::loadFromFile(const std::string&);
template void CSuperRayMapBase<3>::loadFromFile(const std::string&);
template void CSuperRayMapBase<2>::loadWithin(const std::string&, std::uint32_t);
template void CSuperRayMapBase<3>::loadWithin(const std::string&, std::uint32_t);
template void CSuperRayMapBase<2>::saveMetricMapRepresentationToFile(const std::string&) const;
template void CSuperRayMapBase<3>::saveMetricMapRepresentationToFile(const std::string&) const;

}  // namespace superray
