// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/map_compare.h>
#include <superray/eval/progress_meter.h>
#include <superray/maps/option_text.h>
#include <superray/maps/options.h>
#include <superray/storage/for_each_cell.h>
#include <superray/storage/map_file.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

namespace superray {
namespace {

std::uint32_t bitsOf(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}

bool sameBits(float a, float b) {
    return bitsOf(a) == bitsOf(b);
}

/// A map file of either kind, ready to be compared.
struct LoadedMap {
    std::string path;
    int dimension = 3;
    double resolution = 0;
    bool roundedResolution = false;
    CellValues values = CellValues::logOdds;
    float occupied = 0;  ///< threshold [log-odds]
    std::unique_ptr<OccupancyMap<2>> map2;
    std::unique_ptr<OccupancyMap<3>> map3;
};

template <int Dim>
std::unique_ptr<OccupancyMap<Dim>> decode(const MapFile& file) {
    auto map =
        makeStorage<Dim>(StorageType::blockGrid, CellGeometry<Dim>(file.header.resolution));
    decodeCells(file.cells.data(), file.cells.size(), *map);
    return map;
}

LoadedMap loadNative(const std::string& path) {
    const MapFile file = loadMapFile(path);
    LoadedMap loaded;
    loaded.path = path;
    loaded.dimension = file.header.dimension;
    loaded.resolution = file.header.resolution;
    TMapOptions options;
    options.fromText(file.header.options);
    loaded.occupied = options.insertion.sensorModel().occupied();
    if (loaded.dimension == 2)
        loaded.map2 = decode<2>(file);
    else
        loaded.map3 = decode<3>(file);
    return loaded;
}

LoadedMap loadOctomap(const std::string& path) {
    OctomapFile file = readOctomapFile(path);
    LoadedMap loaded;
    loaded.path = path;
    loaded.resolution = file.map->geometry().resolution();
    loaded.roundedResolution = true;
    loaded.values = file.values;
    loaded.map3 = std::move(file.map);
    return loaded;
}

LoadedMap load(const std::string& path) {
    const std::string extension = std::filesystem::path(path).extension().string();
    if (equalIgnoringCase(extension, ".ot") || equalIgnoringCase(extension, ".bt"))
        return loadOctomap(path);
    if (equalIgnoringCase(extension, ".srmap")) return loadNative(path);
    throw InputError(path + ": unknown kind of map; known are .srmap, .ot and .bt");
}

void expectSameGeometry(const LoadedMap& a, const LoadedMap& b) {
    if (a.dimension != b.dimension)
        throw InputError("the maps cannot be compared: " + a.path + " has " +
                         std::to_string(a.dimension) + " dimensions, " + b.path + " has " +
                         std::to_string(b.dimension));
    constexpr double kRounding = 1e-5;  // relative, of OctoMap's 6 digits
    const double tolerance =
        a.roundedResolution || b.roundedResolution ? kRounding * a.resolution : 0;
    if (!(std::abs(a.resolution - b.resolution) <= tolerance))
        throw InputError("the maps cannot be compared: the resolution of " + a.path + " is " +
                         metresText(a.resolution) + ", of " + b.path + " " +
                         metresText(b.resolution));
}

}  // namespace

template <int Dim>
MapDifference compareMaps(const OccupancyMap<Dim>& a, const OccupancyMap<Dim>& b,
                          CellValues compared, float thresholdA, float thresholdB) {
    MapDifference result;
    result.compared = compared;
    const bool onlyOccupancy = compared == CellValues::occupancy;
    forEachCell(a, [&](const Cell<Dim>& cell, float valueA) {
        ++result.cellsA;
        const std::optional<float> valueB = b.logOdds(cell);
        if (!valueB) {
            ++result.missing;
        } else if (onlyOccupancy) {
            result.differing += (valueA >= thresholdA) != (*valueB >= thresholdB);
        } else if (!sameBits(valueA, *valueB)) {
            ++result.differing;
            const double difference = std::abs(double{valueA} - double{*valueB});
            result.largest = std::max(result.largest, difference);
        }
    });
    forEachCell(b, [&](const Cell<Dim>& cell, float) {
        ++result.cellsB;
        result.extra += !a.logOdds(cell).has_value();
    });
    return result;
}

MapDifference compareMapFiles(const std::string& pathA, const std::string& pathB) {
    const LoadedMap a = load(pathA);
    const LoadedMap b = load(pathB);
    expectSameGeometry(a, b);
    const bool onlyOccupancy =
        a.values == CellValues::occupancy || b.values == CellValues::occupancy;
    const auto compared = onlyOccupancy ? CellValues::occupancy : CellValues::logOdds;
    return a.dimension == 2
               ? compareMaps<2>(*a.map2, *b.map2, compared, a.occupied, b.occupied)
               : compareMaps<3>(*a.map3, *b.map3, compared, a.occupied, b.occupied);
}

std::string describe(const MapDifference& d) {
    const bool onlyOccupancy = d.compared == CellValues::occupancy;
    std::ostringstream out;
    out << "cells in A          " << formatCount(d.cellsA) << "\n"
        << "cells in B          " << formatCount(d.cellsB) << "\n"
        << "missing (A only)    " << formatCount(d.missing) << "\n"
        << "extra (B only)      " << formatCount(d.extra) << "\n"
        << "differing           " << formatCount(d.differing)
        << (onlyOccupancy ? " (compared as occupied or free)\n" : "\n");
    if (!onlyOccupancy) out << "largest difference  " << d.largest << " (log-odds)\n";
    out << (d.identical() ? "identical\n" : "different\n");
    return out.str();
}

std::string describeAsJson(const MapDifference& d) {
    const bool onlyOccupancy = d.compared == CellValues::occupancy;
    const nlohmann::ordered_json json{
        {"identical", d.identical()}, {"compared", onlyOccupancy ? "occupancy" : "log-odds"},
        {"cells_a", d.cellsA},        {"cells_b", d.cellsB},
        {"missing", d.missing},       {"extra", d.extra},
        {"differing", d.differing},   {"largest_difference", d.largest}};
    return json.dump(2) + "\n";
}

template MapDifference compareMaps<2>(const OccupancyMap<2>&, const OccupancyMap<2>&,
                                      CellValues, float, float);
template MapDifference compareMaps<3>(const OccupancyMap<3>&, const OccupancyMap<3>&,
                                      CellValues, float, float);

}  // namespace superray
