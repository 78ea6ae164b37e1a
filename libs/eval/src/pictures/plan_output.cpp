// SPDX-License-Identifier: BSD-3-Clause
#include "pictures/plan_output.h"

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <superray/maps/gzip_output.h>
#include <superray/storage/atomic_file.h>
#include <superray/storage/for_each_cell.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace superray {
namespace {

/// Known cells: the lowest and highest along each axis.
struct Extent {
    Cell<2> lowest{0, 0}, highest{0, 0};
    bool empty = true;

    explicit Extent(const OccupancyMap<2>& map) {
        forEachCell(map, [&](const Cell<2>& cell, float) {
            for (std::size_t a = 0; a < 2; ++a) {
                lowest[a] = empty ? cell[a] : std::min(lowest[a], cell[a]);
                highest[a] = empty ? cell[a] : std::max(highest[a], cell[a]);
            }
            empty = false;
        });
    }
    std::size_t width() const { return static_cast<std::size_t>(highest[0] - lowest[0] + 1); }
    std::size_t height() const { return static_cast<std::size_t>(highest[1] - lowest[1] + 1); }
    void check(const std::string& path) const {
        constexpr std::size_t kMostPixels = 32768;
        if (std::max(width(), height()) > kMostPixels)
            throw std::invalid_argument("a plan of " + std::to_string(width()) + " x " +
                                        std::to_string(height()) + " cells, " + path +
                                        ": must have at most 32768 a side");
    }
};

std::string number(double value) {
    char text[40];
    return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace

/// A name as YAML reads it back: in quotes unless it is plain.
std::string yamlText(const std::string& name) {
    const bool isPlain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.';
    }) && std::isalpha(static_cast<unsigned char>(name.front()));
    if (isPlain) return name;
    std::string quoted = "'";
    for (const char c : name) quoted += c == '\'' ? "''" : std::string(1, c);
    return quoted + "'";
}

void writePlanYaml(const OccupancyMap<2>& map, const std::string& path,
                   const std::string& image) {
    const Extent extent(map);
    const double edge = map.geometry().resolution();
    writeFileAtomically(path, "image: " + yamlText(image) +
                                  "\nmode: trinary\nresolution: " + number(edge) +
                                  "\norigin: [" + number(extent.lowest[0] * edge) + ", " +
                                  number(extent.lowest[1] * edge) +
                                  ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\n"
                                  "free_thresh: 0.196\n");
}

void writePlan(const OccupancyMap<2>& map, const SensorModel& model, const std::string& path) {
    constexpr char kOccupied = 0, kFree = static_cast<char>(254),
                   kUnknown = static_cast<char>(205);
    const Extent extent(map);
    extent.check(path);
    std::string pixels(extent.width() * extent.height(), kUnknown);
    forEachCell(map, [&](const Cell<2>& cell, float value) {
        // Rows run down, the map's y runs up.
        const auto row = static_cast<std::size_t>(extent.highest[1] - cell[1]);
        const auto column = static_cast<std::size_t>(cell[0] - extent.lowest[0]);
        pixels[row * extent.width() + column] = value >= model.occupied() ? kOccupied : kFree;
    });
    const auto image = std::filesystem::path(path).replace_extension(".pgm");
    writeFileAtomically(image.string(), "P5\n" + std::to_string(extent.width()) + " " +
                                            std::to_string(extent.height()) + "\n255\n" +
                                            pixels);
    writePlanYaml(map, path, image.filename().string());
}

void writeGridmap(const OccupancyMap<2>& map, const std::string& path) {
    const Extent extent(map);
    extent.check(path);
    const double edge = map.geometry().resolution();
    mrpt::maps::COccupancyGridMap2D grid;
    grid.setSize(static_cast<float>(extent.lowest[0] * edge),
                 static_cast<float>((extent.highest[0] + 1) * edge),
                 static_cast<float>(extent.lowest[1] * edge),
                 static_cast<float>((extent.highest[1] + 1) * edge), static_cast<float>(edge),
                 0.5f);
    forEachCell(map, [&](const Cell<2>& cell, float value) {
        const double occupied = 1 / (1 + std::exp(-static_cast<double>(value)));
        // By the centre of the cell: MRPT may round the size up.
        const int x = grid.x2idx(static_cast<float>((cell[0] + 0.5) * edge));
        const int y = grid.y2idx(static_cast<float>((cell[1] + 0.5) * edge));
        grid.setCell(x, y, static_cast<float>(1 - occupied));
    });
    writeGzip(grid, path);
}

}  // namespace superray
