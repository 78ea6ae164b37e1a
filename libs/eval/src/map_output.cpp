// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/map_output.h>
#include <superray/eval/output_paths.h>
#include <superray/eval/progress_meter.h>
#include <superray/maps/png_output.h>
#include <superray/maps/super_ray_map_base.h>

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "pictures/plan_output.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kExportExtensions = {".bt",  ".ot",   ".ply",    ".3Dscene",
                                                    ".png", ".yaml", ".gridmap"};

void writePicture(const SuperRayMapInterface& map, const std::string& path,
                  const PictureOptions& picture) {
    if (const auto* map2 = dynamic_cast<const CSuperRayMapBase<2>*>(&map)) {
        map2->exportPicture(path);
        // Where the picture is in the map, as ROS says it.
        const fs::path image(path);
        return writePlanYaml(map2->storage(), fs::path(image).replace_extension(".yaml"),
                             image.filename().string());
    }
    const auto& map3 = dynamic_cast<const CSuperRayMapBase<3>&>(map);
    writePng(drawMap(map3.storage(), map3.sensorModel(), picture), path);
}

void writeOctomapFile(const SuperRayMapInterface& map, const std::string& path) {
    const auto* map3 = dynamic_cast<const CSuperRayMapBase<3>*>(&map);
    if (map3 == nullptr)
        throw std::invalid_argument("cannot write " + path + ": " + map.shortClassName() +
                                    " is a 2D map, an OctoMap file holds 3D maps");
    map3->exportOctomap(path);
}

void write(const SuperRayMapInterface& map, const std::string& extension,
           const std::string& path, const PictureOptions& picture) {
    if (extension == ".bt" || extension == ".ot") return writeOctomapFile(map, path);
    if (extension == ".ply") return map.exportPly(path);
    if (extension == ".3Dscene") return map.exportScene(path);
    if (extension == ".yaml" || extension == ".gridmap") {
        const auto* map2 = dynamic_cast<const CSuperRayMapBase<2>*>(&map);
        if (map2 == nullptr)
            throw std::invalid_argument("cannot write " + path + ": " + map.shortClassName() +
                                        " is a 3D map, " + extension + " files hold 2D maps");
        if (extension == ".gridmap") return writeGridmap(map2->storage(), path);
        return writePlan(map2->storage(), map2->sensorModel(), path);
    }
    writePicture(map, path, picture);
}

}  // namespace

std::vector<std::string> filesOfExport(const SuperRayMapInterface& map,
                                       const std::string& path) {
    fs::path beside(path);
    if (beside.extension() == ".yaml") return {path, beside.replace_extension(".pgm")};
    if (beside.extension() == ".png" && map.dimension() == 2)
        return {path, beside.replace_extension(".yaml")};
    return {path};
}

void exportMap(const SuperRayMapInterface& map, const std::string& path,
               const PictureOptions& picture) {
    checkOutputPath(path, kExportExtensions);
    try {
        write(map, fs::path(path).extension().string(), path, picture);
    } catch (const std::invalid_argument& e) {
        throw InputError(path + ": " + oneLineCause(e));
    }
}

std::string describeOutput(const std::string& path) {
    std::error_code error;
    const auto size = fs::file_size(path, error);
    return error ? path : path + ", " + formatBytes(size);
}

}  // namespace superray
