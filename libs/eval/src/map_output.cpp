// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/map_output.h>
#include <superray/eval/progress_meter.h>
#include <superray/maps/png_output.h>
#include <superray/maps/super_ray_map_base.h>
#include <superray/storage/atomic_file.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "pictures/plan_output.h"

namespace superray {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kExportExtensions = {".bt",  ".ot",   ".ply",    ".3Dscene",
                                                    ".png", ".yaml", ".gridmap"};

/// Where a path leads, also through links to what is not there yet.
fs::path targetOf(const std::string& path) {
    constexpr int kMostLinks = 40;  // as Linux has it
    std::error_code error;
    fs::path target = path;
    for (int i = 0; i < kMostLinks && fs::is_symlink(target, error); ++i)
        target = target.parent_path() / fs::read_symlink(target, error);
    return fs::weakly_canonical(target, error);
}

bool isSameFile(const std::string& a, const std::string& b) {
    std::error_code error;
    const auto statusA = fs::status(a, error), statusB = fs::status(b, error);
    if (!fs::exists(statusA) && !fs::exists(statusB)) return targetOf(a) == targetOf(b);
    return fs::is_regular_file(statusA) && fs::is_regular_file(statusB) &&
           fs::equivalent(a, b, error);
}

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

void checkOutputPath(const std::string& path, const std::vector<std::string>& extensions) {
    const fs::path file(path);
    if (std::find(extensions.begin(), extensions.end(), file.extension()) == extensions.end()) {
        std::string known;
        for (const auto& e : extensions) known += (known.empty() ? "" : ", ") + e;
        throw InputError(path + ": unknown kind of output; its name must end in " + known);
    }
    std::error_code error;
    if (fs::is_directory(file, error)) throw InputError(path + ": is a folder");
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, error))
        throw InputError(path + ": the folder " + folder.string() + " does not exist");
    try {
        checkOutputFile(path);
    } catch (const MapFileError& e) {
        throw InputError(e.what());
    }
}

void checkOutputsApart(const std::vector<std::string>& inputs,
                       const std::vector<std::string>& outputs) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        for (const std::string& input : inputs)
            if (isSameFile(outputs[i], input))
                throw InputError(outputs[i] + ": would overwrite the input " + input);
        for (std::size_t k = 0; k < i; ++k)
            if (isSameFile(outputs[i], outputs[k]))
                throw InputError(outputs[i] + ": would overwrite another output, " +
                                 outputs[k]);
    }
}

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
