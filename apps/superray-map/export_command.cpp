// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/map_output.h>
#include <superray/eval/output_paths.h>
#include <superray/maps/map_factory.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.h"

namespace superray {
namespace {

/// \param asked the options of pictures that are given, e.g. "--width, --height"
void checkPictureOptions(const std::string& asked, const std::string& output,
                         const SuperRayMapInterface& map) {
    if (asked.empty()) return;
    if (std::filesystem::path(output).extension() != ".png")
        throw InputError(asked + " contradicts " + output +
                         ": it is for pictures of 3D maps (.png)");
    if (map.dimension() != 3)
        throw InputError(asked + " contradicts " + map.shortClassName() +
                         ": it is for pictures of 3D maps; those of a 2D map have a pixel a "
                         "cell");
}

}  // namespace

Command declareExport(CLI::App& app) {
    struct Arguments {
        std::string map, output;
        PictureOptions picture;
    };
    auto arguments = std::make_shared<Arguments>();
    app.footer(
        "The format follows from the name of the output:\n"
        "  .ot       OctoMap, log-odds (3D maps)\n"
        "  .bt       OctoMap, occupied or free only (3D maps)\n"
        "  .ply      occupied cells as points with probability\n"
        "  .3Dscene  MRPT scene, for SceneViewer3D\n"
        "  .png      picture; of 2D maps with a .yaml beside it that tells its origin\n"
        "  .yaml     for ROS's map_server and nav2, with a .pgm beside it (2D maps)\n"
        "  .gridmap  MRPT's COccupancyGridMap2D (2D maps)\n\n"
        "Examples:\n"
        "  superray-map export drive.srmap drive.ot\n"
        "  superray-map export plan.srmap plan.yaml\n"
        "  superray-map export hall.srmap hall.png --cut-above 4\n");
    app.add_option("MAP", arguments->map, "Map: .srmap, .ot or .bt")
        ->required()
        ->type_name("FILE");
    app.add_option("OUT", arguments->output,
                   "File to write: .bt, .ot, .ply, .3Dscene, .png, .yaml or .gridmap")
        ->required()
        ->type_name("OUTPUT");
    app.add_option("--cut-above", arguments->picture.cutAbove,
                   "Pictures of 3D maps: leave out what is above this height")
        ->type_name("METRES");
    app.add_option("--width", arguments->picture.width,
                   "Pictures of 3D maps: pixels; default 1600")
        ->type_name("N");
    app.add_option("--height", arguments->picture.height, "Likewise; default 900")
        ->type_name("N");
    return [arguments, &app] {
        std::string asked;
        for (const char* option : {"--cut-above", "--width", "--height"})
            if (app.count(option) > 0)
                asked += (asked.empty() ? "" : ", ") + std::string(option);
        const std::string& output = arguments->output;
        const auto map = loadMap(arguments->map);
        const auto& info = dynamic_cast<const SuperRayMapInterface&>(*map);
        checkPictureOptions(asked, output, info);
        checkOutputsApart({arguments->map}, filesOfExport(info, output));
        exportMap(info, output, arguments->picture);
        std::cout << describeOutput(arguments->output) << "\n";
        return int{kSuccess};
    };
}

}  // namespace superray
