// SPDX-License-Identifier: BSD-3-Clause
#include "views/map_export.h"

#include <mrpt/img/CImage.h>
#include <octomap/OcTree.h>
#include <superray/maps/png_output.h>
#include <superray/storage/atomic_file.h>
#include <superray/storage/octree.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace superray {

void writeOctomap(const OccupancyMap<3>& map, const SensorModel& model,
                  const std::string& path) {
    const std::string extension = std::filesystem::path(path).extension().string();
    if (extension != ".bt" && extension != ".ot")
        throw std::invalid_argument("OctoMap file " + path + ": must end in .bt or .ot");

    std::unique_ptr<Octree> filled;
    const auto* octree = dynamic_cast<const Octree*>(&map);
    if (!octree) {
        filled = std::make_unique<Octree>(map.geometry());
        map.forEachBlock([&](const BlockView<3>& block) { filled->setBlock(block); });
        octree = filled.get();
    }
    // OctoMap's own writers to files do not look whether the disk is full.
    AtomicStream file(path);
    if (extension == ".ot") {
        octree->tree().write(file);
        return file.commit();
    }
    // .bt holds one bit per leaf, so what counts as occupied must be set first.
    octomap::OcTree binary(octree->tree());
    binary.setOccupancyThres(model.probabilities().occupancyThreshold);
    binary.setClampingThresMin(model.probabilities().clampMin);
    binary.setClampingThresMax(model.probabilities().clampMax);
    binary.toMaxLikelihood();
    binary.prune();
    binary.writeBinaryConst(file);
    file.commit();
}

template <int Dim>
void writePly(const OccupancyMap<Dim>& map, const SensorModel& model, const std::string& path) {
    struct Vertex {
        float x, y, z, probability;
    };
    std::vector<Vertex> vertices;
    map.forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i) {
            if (!block.known.test(i) || block.values[i] < model.occupied()) continue;
            const Point<Dim> p = map.geometry().center(cellInBlock<Dim>(block.key, i));
            vertices.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]),
                                Dim == 3 ? static_cast<float>(p[Dim - 1]) : 0.0f,
                                static_cast<float>(probabilityOf(block.values[i]))});
        }
    });
    AtomicStream file(path);
    file << "ply\nformat binary_little_endian 1.0\ncomment occupied cells, resolution "
         << map.geometry().resolution() << " m\nelement vertex " << vertices.size()
         << "\nproperty float x\nproperty float y\nproperty float z\n"
            "property float probability\nend_header\n";
    file.write(reinterpret_cast<const char*>(vertices.data()),
               static_cast<std::streamsize>(vertices.size() * sizeof(Vertex)));
    file.commit();
}

template void writePly(const OccupancyMap<2>&, const SensorModel&, const std::string&);
template void writePly(const OccupancyMap<3>&, const SensorModel&, const std::string&);

void writePicture(const OccupancyMap<2>& map, const SensorModel& model,
                  const std::string& path) {
    // The grey values of ROS map files.
    constexpr std::uint8_t kOccupied = 0, kFree = 254, kUnknown = 205;
    constexpr int kMaxSide = 32768;
    const auto s = summarize(map, model);
    const int width = s.known == 0 ? 1 : s.highest[0] - s.lowest[0] + 1;
    const int height = s.known == 0 ? 1 : s.highest[1] - s.lowest[1] + 1;
    if (width > kMaxSide || height > kMaxSide)
        throw std::invalid_argument("picture " + path + " of " + std::to_string(width) + " x " +
                                    std::to_string(height) + " cells: must have at most " +
                                    std::to_string(kMaxSide) + " a side");
    mrpt::img::CImage image(static_cast<unsigned>(width), static_cast<unsigned>(height),
                            mrpt::img::CH_GRAY);
    for (int y = 0; y < height; ++y)
        std::memset(image.ptrLine<std::uint8_t>(static_cast<unsigned>(y)), kUnknown,
                    static_cast<std::size_t>(width));
    map.forEachBlock([&](const BlockView<2>& block) {
        for (int i = 0; i < kBlockCells<2>; ++i) {
            if (!block.known.test(i)) continue;
            const Cell<2> c = cellInBlock<2>(block.key, i);
            // Picture rows run down, the map's y runs up.
            auto* row = image.ptrLine<std::uint8_t>(static_cast<unsigned>(s.highest[1] - c[1]));
            row[c[0] - s.lowest[0]] = block.values[i] >= model.occupied() ? kOccupied : kFree;
        }
    });
    writePng(image, path);
}

}  // namespace superray
